#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace feder {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Free coordinates of a node: bit 0 is x, bit 1 is y, bit 2 is z. A masked coordinate never moves.
using FreeMask = std::uint8_t;
inline constexpr FreeMask kPinned = 0;
inline constexpr FreeMask kFree = 7;
inline constexpr FreeMask kPlanarXY = 3;

/// A place a row can hold on to. Particles and world points are nodes; their local point is the node itself.
struct Anchor {
  int node = -1;
};

/// What moves: t [s], q [m] and v [m/s] with 3 numbers per node (world points included, at rest).
struct State {
  double t = 0.0;
  VectorXd q;
  VectorXd v;
};

/// What an integrator remembers between steps. Plain data: saved with the state, a resumed run is bitwise
/// equal.
struct History {
  VectorXd lambda;            ///< multipliers of the last step [row force], empty before the first
  VectorXd force;             ///< total force at (q, v, t) [N], 3 per node, empty if not known
  double suggested_dt = 0.0;  ///< next step proposed by step-size control [s], 0 if none
};

}  // namespace feder
