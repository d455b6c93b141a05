#pragma once

#include <span>

#include "engine/geometry/bounding_volumes.h"
#include "engine/geometry/triangle_mesh.h"

namespace feder {

/// Smallest box along given axes (columns, a rotation) that contains all points, at least one: |axes^T (p -
/// centre)|
/// <= half holds for each of them, for half is padded by the rounding of this very product.
Obb box_along(const Matrix3d& axes, std::span<const Vector3d> points);

/// Box along the critical axes of the points' covariance, longest spread first; one point, collinear and
/// coplanar points give half edges of rounding. Follows the density of the points: where that is not meant,
/// use the mesh. Misuse: no points, or a covariance that is not finite.
Obb fit_obb(std::span<const Vector3d> points);

/// The same of a surface by its area, for all triangles of a mesh or for some (indices into mesh.triangles,
/// at least one; one out of range is not checked). A surface without area is boxed as its vertices.
Obb fit_obb(const TriangleMesh& mesh);
Obb fit_obb(const TriangleMesh& mesh, std::span<const int> triangles);

inline Obb obb_of(const Aabb& box) {
  return {0.5 * box.min + 0.5 * box.max, Matrix3d::Identity(), 0.5 * box.max - 0.5 * box.min};
}

/// [m^3]
inline double volume(const Obb& box) {
  return 8.0 * box.half.prod();
}

/// Closed; up to rounding at the faces.
inline bool contains(const Obb& box, const Vector3d& point) {
  return ((box.axes.transpose() * (point - box.centre)).cwiseAbs().array() <= box.half.array()).all();
}

}  // namespace feder
