#pragma once

#include <cmath>

#include "models/model.h"

namespace feder {

/// Scene S3c(N): n boxes in a row along +x, ball joints at the middle of their ends, the first to the world,
/// falling from rest.
struct RigidChain {
  int n = 100;                  ///< boxes
  double mass = 0.1;            ///< of each box [kg]
  double link = 0.1;            ///< length of a box [m]
  double width = 0.02;          ///< of its square section [m]
  double stiffness = INFINITY;  ///< of each joint [N/m]; infinite: a hard joint
  double damping_time = 0.0;    ///< tau [s]
  double gravity = 9.81;        ///< along -y [m/s^2]
};

Model make_rigid_chain(const RigidChain& options = {});
ModelInfo rigid_chain_model();

}  // namespace feder
