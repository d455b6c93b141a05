// Oriented boxes (notes A7): axes b_k = eigenvectors of the covariance, s_k = [min, max] of b_k^T p, half
// edges (max - min)/2, centre at the midpoint of the s_k. The mean is no centre: it follows where the points
// are dense.
#include "engine/geometry/obb.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "engine/check.h"
#include "engine/geometry/best_line.h"

namespace feder {

Obb box_along(const Matrix3d& axes, std::span<const Vector3d> points) {
  FEDER_CHECK(!points.empty(), "a box needs at least one point");
  const Vector3d origin = points[0];

  // extents from the first point, whose differences carry no error of the distance to the world's origin
  Vector3d low = Vector3d::Zero(), high = Vector3d::Zero();
  for (const Vector3d& p : points) {
    const Vector3d s = axes.transpose() * (p - origin);
    low = low.cwiseMin(s);
    high = high.cwiseMax(s);
  }
  const Vector3d middle = 0.5 * (low + high);
  const Vector3d centre = origin + axes * middle;

  // padding: the products' rounding, and that of the centre where it is far away
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  const double size = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
  const double padding =
      8.0 * kEpsilon * size + (size > 0.0 ? 2.0 * kEpsilon * centre.cwiseAbs().maxCoeff() : 0.0);
  return {centre, axes, (0.5 * (high - low)).array() + padding};
}

Obb fit_obb(std::span<const Vector3d> points) {
  return box_along(critical_axes(point_spread(points).covariance).axes, points);
}

Obb fit_obb(const TriangleMesh& mesh, std::span<const int> triangles) {
  std::vector<Vector3d> corners;
  corners.reserve(3 * triangles.size());
  for (int k : triangles)
    for (int vertex : mesh.triangles[k]) corners.push_back(mesh.vertices[vertex]);
  const Spread spread = surface_spread(mesh, triangles);
  return spread.weight > 0.0 ? box_along(critical_axes(spread.covariance).axes, corners) : fit_obb(corners);
}

Obb fit_obb(const TriangleMesh& mesh) {
  std::vector<int> all(mesh.triangles.size());
  std::iota(all.begin(), all.end(), 0);
  return fit_obb(mesh, all);
}

}  // namespace feder
