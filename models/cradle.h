#pragma once

#include <cmath>

#include "models/model.h"

namespace feder {

/// Newton's cradle: balls in a row on rods of equal length; some are lifted and let go. With a gap they meet
/// pair after pair, without one all at once, and then rigid impact laws do not tell who flies off.
struct Cradle {
  int n = 5;
  int lifted = 1;               ///< balls at the start of the row that are let go at `angle`
  double angle = 0.3;           ///< from hanging, towards -x [rad]
  double gap = 1e-3;            ///< between neighbours at rest [m]
  double restitution = 1.0;     ///< e in [0, 1]
  double mass = 1.0;            ///< of each ball [kg]
  double radius = 0.05;         ///< [m]
  double length = 1.0;          ///< of the rods [m]
  double stiffness = INFINITY;  ///< of the rods [N/m]
  double gravity = 9.81;        ///< along -y [m/s^2]
};

Model make_cradle(const Cradle& options = {});
ModelInfo cradle_model();

}  // namespace feder
