#pragma once

#include "models/model.h"

namespace feder {

/// A box on a plane that falls off towards +x: it slides, stops, or rests. Exact unless it would tip over.
struct Incline {
  double angle = 0.5;     ///< of the plane from the horizontal [rad]
  double friction = 0.3;  ///< Coulomb's mu
  double speed = 0.0;     ///< at the start, downhill; negative: uphill [m/s]
  double mass = 1.0;      ///< [kg]
  double edge = 0.2;      ///< of the box along and across the plane; it is half as high [m]
  double gravity = 9.81;  ///< along -y [m/s^2]
};

/// Way downhill from the start and its rate.
struct Slide {
  double way = 0.0, speed = 0.0;  ///< [m, m/s]
};
Slide incline_slide(const Incline& options, double t);

Model make_incline(const Incline& options = {});
ModelInfo incline_model();

}  // namespace feder
