#pragma once

#include <array>

#include "models/model.h"

namespace feder {

enum class RodSupport { kCantilever, kPinnedEnds };

/// An elastic rod along x: distance rows EA / l and curvature rows EI / l over n nodes, started in the first
/// bending mode of beam theory. The cantilever is clamped by its first two nodes, half a link on either side
/// of x = 0.
struct BendingRod {
  int n = 21;
  double length = 1.0;             ///< [m]
  double line_density = 0.1;       ///< [kg/m]
  double bending_stiffness = 0.1;  ///< EI [N m^2]
  double axial_stiffness = 1e4;    ///< EA [N], infinite: links are rods
  RodSupport support = RodSupport::kCantilever;
  double amplitude = 1e-3;    ///< largest deflection, along y [m]
  double gravity = 0.0;       ///< along -y [m/s^2]
  double damping_time = 0.0;  ///< tau of all rows [s]
  double drag = 0.0;          ///< per node [kg/s]
};

/// Length of a link [m].
double rod_link(const BendingRod& options);

/// The first three angular frequencies of beam theory, (beta L)^2 / L^2 sqrt(EI / line density) [rad/s].
std::array<double, 3> beam_frequencies(const BendingRod& options);

Model make_bending_rod(const BendingRod& options = {});
ModelInfo bending_rod_model();

}  // namespace feder
