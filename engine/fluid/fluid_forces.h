#pragma once

#include <vector>

#include "engine/fluid/fluid_pairs.h"

namespace feder {

class Fluid;

/// Forces of all pairs, see fluid.cpp. Newton's third law holds pair by pair, to rounding.
struct FluidForces {
  std::vector<double> f;  ///< D per place [N]

  /// velocity: D per point [m/s], used where the fluid is viscous.
  void evaluate(const Fluid& fluid, const FluidPairs& pairs, const std::vector<double>& velocity);

 private:
  template <int D, bool kViscous>
  void add_pairs(const FluidPairs& pairs, double softening);

  std::vector<double> push_;           // m p/rho^2
  std::vector<double> u_, thickness_;  // velocity by place; m/rho sqrt of the viscosity
};

}  // namespace feder
