#pragma once

#include "models/model.h"
#include "models/modes.h"

namespace feder {

/// n beads on a prestretched string between two fixed points, displaced across the string. The notes' step
/// without geometric stiffness has a sharp limit here: dt < 2 / omega of the highest transverse mode (notes
/// E8).
struct TautString {
  int n = 20;
  double mass = 0.01;                                 ///< of each bead [kg]
  double stiffness = 1e4;                             ///< of each of the n + 1 springs [N/m]
  double span = 1.0;                                  ///< distance of the fixed points [m]
  double tension = 10.0;                              ///< at rest [N]; < stiffness times link length
  std::vector<Mode> modes = {{1, 1e-3}, {-1, 1e-5}};  ///< initial displacement along y, amplitudes [m]
  double damping_time = 0.0;                          ///< tau [s]
  double drag = 0.0;                                  ///< [kg/s]
};

/// Small transverse oscillations: omega_j = 2 sqrt(tension / (mass link)) sin(j pi / (2 (n + 1))) [rad/s].
double taut_string_frequency(const TautString& options, int j);

Model make_taut_string(const TautString& options = {});
ModelInfo taut_string_model();

}  // namespace feder
