// Sphere: round the middle of the box. Oriented box: axes are the eigenvectors of the covariance of the
// surface (every triangle with its area; of the corners where there is no area), the extents along them
// centre the box.
#include "engine/geometry/bvh_volumes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "engine/geometry/aabb.h"
#include "engine/geometry/obb.h"

namespace feder {
namespace {

// Rounding of a pose and of the projections in a test, in units of the last place of the largest coordinate.
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kSlack = 64.0 * std::numeric_limits<double>::epsilon();

template <class Visit>
void for_corners(const TriangleMesh& mesh, int first, int count, Visit&& visit) {
  for (int k = first; k < first + count; ++k)
    for (int vertex : mesh.triangles[k]) visit(mesh.vertices[vertex]);
}

}  // namespace

void fit_volume(const TriangleMesh& mesh, int first, int count, Aabb& out) {
  out = empty_aabb();
  for_corners(mesh, first, count, [&out](const Vector3d& x) { out = merged(out, x); });
}

void fit_volume(const TriangleMesh& mesh, int first, int count, Sphere& out) {
  Aabb box;
  fit_volume(mesh, first, count, box);
  out.centre = 0.5 * (box.min + box.max);
  double radius_squared = 0.0;
  for_corners(mesh, first, count, [&](const Vector3d& x) {
    radius_squared = std::max(radius_squared, (x - out.centre).squaredNorm());
  });
  out.radius = std::sqrt(radius_squared);
}

void fit_volume(const TriangleMesh& mesh, int first, int count, Obb& out) {
  std::vector<int> triangles(static_cast<std::size_t>(count));
  std::iota(triangles.begin(), triangles.end(), first);
  out = fit_obb(mesh, triangles);
}

double reach_of(const Sphere& ball) {
  return ball.centre.norm() + ball.radius;
}
double reach_of(const Aabb& box) {
  return box.min.cwiseAbs().cwiseMax(box.max.cwiseAbs()).norm();
}
double reach_of(const Obb& box) {
  return box.centre.norm() + box.half.norm();
}

Relative relative(const Pose& a, const Pose& b, double reach) {
  Relative out;
  out.rotation = a.rotation.transpose() * b.rotation;
  out.size = out.rotation.cwiseAbs();
  out.position = a.rotation.transpose() * (b.position - a.position);
  out.turned = out.rotation != Matrix3d::Identity();
  out.slack = kSlack * (reach + out.position.norm());
  return out;
}

double ray_slack(double reach, const Vector3d& origin) {
  return kSlack * (reach + origin.norm());
}

double ray_entry(const Aabb& box, const Vector3d& origin, const Vector3d& direction, double slack) {
  double enter = 0.0, leave = kInfinity;
  for (int c = 0; c < 3; ++c) {
    const double low = box.min[c] - slack - origin[c], high = box.max[c] + slack - origin[c];
    if (direction[c] == 0.0) {
      if (low > 0.0 || high < 0.0) return kInfinity;
      continue;
    }
    const double s = low / direction[c], t = high / direction[c];
    enter = std::max(enter, std::min(s, t));
    leave = std::min(leave, std::max(s, t));
  }
  return enter <= leave ? enter : kInfinity;
}

double ray_entry(const Obb& box, const Vector3d& origin, const Vector3d& direction, double slack) {
  return ray_entry(Aabb{-box.half, box.half}, box.axes.transpose() * (origin - box.centre),
                   box.axes.transpose() * direction, slack);
}

double ray_entry(const Sphere& ball, const Vector3d& origin, const Vector3d& direction, double slack) {
  const double speed = direction.norm(), radius = ball.radius + slack;
  const Vector3d to = ball.centre - origin;
  if (to.norm() <= radius) return 0.0;
  if (speed == 0.0) return kInfinity;
  const Vector3d unit = direction / speed;
  const double along = to.dot(unit), half_squared = radius * radius - (to - along * unit).squaredNorm();
  if (along < 0.0 || half_squared < 0.0) return kInfinity;
  return std::max(along - std::sqrt(half_squared), 0.0) / speed;
}

BoxGaps box_gaps(const Obb& a, const Obb& b, const Relative& frame) {
  const Matrix3d axes = a.axes.transpose() * frame.rotation * b.axes;
  const Vector3d centre = a.axes.transpose() * (frame(b.centre) - a.centre);
  return box_gaps(a.half, b.half, centre, axes, axes.cwiseAbs());
}

}  // namespace feder
