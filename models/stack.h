#pragma once

#include "models/model.h"

namespace feder {

/// A tower of cubes on the plane y = 0, at rest for ever.
struct Stack {
  int n = 5;
  double edge = 1.0;      ///< of each cube [m]
  double mass = 1.0;      ///< of each cube but the top one [kg]
  double ratio = 1.0;     ///< mass of the top cube over that of the others
  double friction = 0.5;  ///< Coulomb's mu
  double gravity = 9.81;  ///< along -y [m/s^2]
};

Model make_stack(const Stack& options = {});
ModelInfo stack_model();

}  // namespace feder
