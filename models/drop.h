#pragma once

#include "models/model.h"

namespace feder {

enum class DropStart { kFace, kEdge, kCorner };

/// A cube falls from rest on its face, edge or corner onto the plane y = 0. Exact up to the second impact
/// where the first one does not rub.
struct Drop {
  DropStart start = DropStart::kCorner;
  double tilt = 0.2;         ///< of edge or corner out of the vertical below the centre [rad]
  double height = 0.5;       ///< of the lowest point [m]
  double restitution = 0.5;  ///< e in [0, 1]
  double friction = 0.0;     ///< Coulomb's mu
  double mass = 1.0;         ///< [kg]
  double edge = 0.2;         ///< of the cube [m]
  double gravity = 9.81;     ///< along -y [m/s^2]
};

/// The first impact.
struct DropImpact {
  double time;      ///< [s]
  double impulse;   ///< of all its points together, upwards [N s]
  double velocity;  ///< of the centre right after it, upwards [m/s]
  double spin;      ///< about +z right after it [rad/s]
  double flight;    ///< until the next impact [s]; 0 if the cube does not leave the plane
};
DropImpact drop_impact(const Drop& options);

Model make_drop(const Drop& options = {});
ModelInfo drop_model();

}  // namespace feder
