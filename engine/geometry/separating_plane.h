#pragma once

#include <span>

#include "engine/state.h"

namespace feder {

/// Two convex polytopes A and B, each the hull of its points.
struct ConvexSeparation {
  bool overlap = true;    ///< no gap above 1e-14 of the pair's size; touching is overlap
  double distance = 0.0;  ///< 0 if they overlap [m]
  Vector3d point_a =
      Vector3d::Zero();  ///< the closest points; if they overlap, a common one to 1e-9 of the size [m]
  Vector3d point_b = Vector3d::Zero();
  /// If disjoint: normal . (x - point) < 0 for all x of A, > 0 for all of B, as far as the last bit of
  /// `point` allows; otherwise the normal is 0.
  Vector3d normal = Vector3d::Zero();  ///< unit, from A to B
  Vector3d point = Vector3d::Zero();   ///< [m]
};

/// Closest points and a separating plane, by O(iterations (n + m)) operations. Any points: duplicates,
/// segments and flat hulls are fine. The same for (B, A) with the roles exchanged. Misuse: no points, or one
/// that is not finite.
ConvexSeparation separation(std::span<const Vector3d> a, std::span<const Vector3d> b);

}  // namespace feder
