#pragma once

#include <cmath>

#include "models/model.h"

namespace feder {

/// Two bars on hinges about z, hanging along -y at angle 0.
struct DoublePendulum {
  double upper_mass = 1.0, lower_mass = 1.0;      ///< [kg]
  double upper_length = 0.5, lower_length = 0.5;  ///< [m]
  double width = 0.02;                            ///< of the square sections [m]
  double upper_angle = 1.2, lower_angle = 0.6;    ///< from hanging [rad]
  double upper_rate = 0.0, lower_rate = 0.0;      ///< angular velocities [rad/s]
  double stiffness = INFINITY;                    ///< of each hinge's place [N/m]
  double angular_stiffness = INFINITY;            ///< of each hinge's axis [N m]
  double gravity = 9.81;                          ///< along -y [m/s^2]
};

Model make_double_pendulum(const DoublePendulum& options = {});
ModelInfo double_pendulum_model();

}  // namespace feder
