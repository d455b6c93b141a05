#pragma once

#include "models/model.h"
#include "models/modes.h"

namespace feder {

/// n masses between two fixed points, moving along the line they stand on (x is their only free coordinate).
/// Exactly linear as long as no two nodes meet, so a superposition of modes is an exact solution, damped or
/// not.
struct Chain {
  int n = 10;
  double mass = 0.01;                                ///< of each node [kg]
  double stiffness = 1e4;                            ///< of each spring [N/m]
  double rest_length = 0.1;                          ///< of each spring [m]
  std::vector<Mode> modes = {{1, 1e-2}, {3, 5e-3}};  ///< initial displacement, amplitudes [m]
  double damping_time = 0.0;                         ///< tau [s]
  double drag = 0.0;                                 ///< [kg/s]
};

/// omega_j [rad/s], j = 1 ... n.
double chain_frequency(const Chain& options, int j);

Model make_chain(const Chain& options = {});
ModelInfo chain_model();

}  // namespace feder
