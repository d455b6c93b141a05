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

/// A place a row can hold on to: a node (particle or world point), or a point of a body.
struct Anchor {
  int node = -1;
  int body = -1;                      ///< body id; `node` is then unused
  Vector3d point = Vector3d::Zero();  ///< in the axes the body was given in [m]
};

/// What moves: t [s]; q: 3 numbers per particle, world point and centre of a body [m], then a unit quaternion
/// (w, x, y, z) per body; v: 3 per node [m/s], the nodes of bodies being their centres and, last, their spins
/// (angular velocity in principal axes [rad/s]). engine/body.h reads it in world axes.
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
  double last_dt = 0.0;       ///< of the last step, for methods that ask [s], 0 before the first
  VectorXd
      contacts;  ///< 6 per contact that pushed: colliders a and b, feature, impulse on b in the world [N s]
};

}  // namespace feder
