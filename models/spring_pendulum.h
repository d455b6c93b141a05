#pragma once

#include "models/model.h"

namespace feder {

/// A planar pendulum on a stiff spring: slow swing, fast stretch. No exact solution; the energy is constant.
struct SpringPendulum {
  double mass = 1.0;        ///< [kg]
  double length = 1.0;      ///< rest length [m]
  double stiffness = 1e4;   ///< [N/m]
  double angle = 1.5;       ///< initial angle from hanging [rad]
  double elongation = 0.0;  ///< initial stretch of the spring [m], > -length
  double speed = 0.0;       ///< initial velocity across the spring [m/s]
  double gravity = 9.81;    ///< along -y [m/s^2]
};

Model make_spring_pendulum(const SpringPendulum& options = {});
ModelInfo spring_pendulum_model();

}  // namespace feder
