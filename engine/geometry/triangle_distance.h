#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "engine/geometry/triangle_overlap.h"

namespace feder {

/// Triangle [m]; may be degenerate (a segment or a point) for every function here.
using Triangle = std::array<Vector3d, 3>;

enum class Feature : std::uint8_t { kFace, kEdge, kVertex };

/// A point of a triangle: in its face, on its edge `index` (from corner index to the next) or its corner
/// `index`.
struct TrianglePoint {
  Vector3d point;
  double distance_squared;  ///< to the point asked for [m^2]
  Feature feature;
  int index;  ///< 0 for the face
};

/// The point of the triangle nearest to p [m].
TrianglePoint closest_point(const Triangle& triangle, const Vector3d& p);

/// A nearest pair of points of two triangles [m]; equal up to rounding, and distance exactly 0, where they
/// meet.
struct ClosestPair {
  Vector3d a, b;
  double distance_squared;
};
ClosestPair closest_points(const Triangle& a, const Triangle& b);

/// The nearest points of the segments from p[0] to p[1] and from q[0] to q[1] [m].
ClosestPair closest_points(const std::array<Vector3d, 2>& p, const std::array<Vector3d, 2>& q);

/// Smallest t in [0, limit] with origin + t direction on the triangle, both sides count. Rays in its plane
/// (to rounding) miss it, all rays miss a triangle without area.
std::optional<double> ray_hit(const Triangle& triangle, const Vector3d& origin, const Vector3d& direction,
                              double limit);

}  // namespace feder
