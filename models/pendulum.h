#pragma once

#include <limits>

#include "models/model.h"

namespace feder {

/// One mass on a rod, released at rest from a large angle. With a rod (stiffness infinite) the motion is
/// known: theta(t) = 2 asin(k sn(K - omega t | k)), k = sin(angle / 2), omega = sqrt(g / length).
struct Pendulum {
  double mass = 1.0;      ///< [kg]
  double length = 1.0;    ///< [m]
  double angle = 3.0;     ///< initial angle from hanging, inside (0, pi) [rad]
  double gravity = 9.81;  ///< along -y [m/s^2]
  double stiffness = std::numeric_limits<double>::infinity();  ///< [N/m], infinite: a rod
};

/// Time of one full swing [s] of the rigid pendulum, 4 K / omega.
double pendulum_period(const Pendulum& options);

Model make_pendulum(const Pendulum& options = {});
ModelInfo pendulum_model();

}  // namespace feder
