#pragma once

#include <utility>
#include <vector>

#include "engine/fluid/fluid.h"
#include "engine/step_rows.h"

namespace feder {

/// Density as rows, phi = rho/rho_0 - 1 <= 0 at the end of a step of dt: one row per particle, in the order
/// of Fluid::particles(), then one per boundary sample that has a pressure, over the velocities of particles,
/// nodes and bodies near it. Where tension is clamped rows only push. A fluid of finite sound speed c has
/// gamma = 1/(dt^2 m c^2), so y/dt = -m c^2 phi: the implicit form of its linear equation of state.
struct DensityRows {
  StepRows rows;              ///< J is -d phi, r is -phi/dt: the push y [N s] is dt m p rho_0/rho^2
  VectorXd phi;               ///< per row
  std::vector<int> point_of;  ///< per row: particle, or number of particles + sample

  /// False where a position is not finite.
  bool evaluate(const Fluid& fluid, const VectorXd& q, double dt);

 private:
  void list_neighbours();
  void add_gradient(const Fluid& fluid, const VectorXd& q, int point, const Vector3d& gradient);

  struct Held {  // what a row gives one holder of samples
    int node, spin;
    Vector3d force, torque;
  };
  FluidPairs pairs_;
  std::vector<int> place_of_, start_;
  std::vector<std::pair<int, double>> around_;  // place and slope
  std::vector<Held> held_;
};

}  // namespace feder
