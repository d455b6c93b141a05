#pragma once

#include <array>

#include "engine/state.h"

namespace feder {

/// Corners [m]; may be a segment or a point.
using Triangle = std::array<Vector3d, 3>;

/// Closed: touching counts as overlap. Fast: two planes and two edge pairs decide most pairs, the rest goes
/// to `separation`. Outside a band of 1e-12 of the pair's size the answer is right; it is the same for (b,
/// a).
bool overlap(const Triangle& a, const Triangle& b);

/// gap > 0: the distance of the triangles. gap <= 0: they overlap and -gap is the shortest translation that
/// parts them, 0 where they touch or share a plane. Accurate to 1e-14 of the pair's size. [m]
struct TriangleSeparation {
  bool overlap = true;  ///< no gap above the rounding
  double gap = 0.0;
  Vector3d axis = Vector3d::UnitX();  ///< unit, from a to b; arbitrary where all corners coincide
};
TriangleSeparation separation(const Triangle& a, const Triangle& b);

}  // namespace feder
