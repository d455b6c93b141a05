#pragma once

#include <cmath>

#include "models/model.h"

namespace feder {

/// n equal bars in a row on hinges about z, straight at the start.
struct NPendulum {
  int n = 10;                           ///< bars
  double mass = 0.1;                    ///< of each [kg]
  double link = 0.1;                    ///< length of each [m]
  double width = 0.02;                  ///< of the square section [m]
  double angle = 1.0;                   ///< of all from hanging [rad]
  double stiffness = INFINITY;          ///< of each hinge's place [N/m]
  double angular_stiffness = INFINITY;  ///< of each hinge's axis [N m]
  double gravity = 9.81;                ///< along -y [m/s^2]
};

Model make_n_pendulum(const NPendulum& options = {});
ModelInfo n_pendulum_model();

}  // namespace feder
