// Nearest points by the regions of Ericson, Real-Time Collision Detection (2005), sections 5.1.5 and 5.1.9,
// with edges first where a triangle has no area. Two triangles that do not meet are nearest in two edges or
// in a corner and a face; that they meet is seen from an edge that crosses a face. Ray: Moeller and Trumbore
// 1997.
#include "engine/geometry/triangle_distance.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace feder {
namespace {

// A determinant below this share of the lengths of its columns is rounding: ray in the plane, or no area.
constexpr double kFlat = 64.0 * std::numeric_limits<double>::epsilon();
// Squared sine of an angle below which the foot in the face may be worse than one on an edge.
constexpr double kNeedle = 1e-8;
constexpr double kTouch = 1e-24;  // (1e-12)^2, the band of the overlap test

TrianglePoint closest_of_edges(const Triangle& triangle, const Vector3d& p) {
  TrianglePoint best{{}, std::numeric_limits<double>::infinity(), Feature::kVertex, 0};
  for (int k = 0; k < 3; ++k) {
    const Vector3d &from = triangle[k], edge = triangle[(k + 1) % 3] - from;
    const double length_squared = edge.squaredNorm(), along = edge.dot(p - from);
    TrianglePoint here{from, 0.0, Feature::kVertex, k};
    if (along > 0.0 && along < length_squared) {
      here = {from + along / length_squared * edge, 0.0, Feature::kEdge, k};
    } else if (along > 0.0) {
      here = {triangle[(k + 1) % 3], 0.0, Feature::kVertex, (k + 1) % 3};
    }
    here.distance_squared = (p - here.point).squaredNorm();
    if (here.distance_squared < best.distance_squared) best = here;
  }
  return best;
}

void keep_nearer(ClosestPair& best, const ClosestPair& other) {
  if (other.distance_squared < best.distance_squared) best = other;
}

}  // namespace

TrianglePoint closest_point(const Triangle& triangle, const Vector3d& p) {
  const Vector3d ab = triangle[1] - triangle[0], ac = triangle[2] - triangle[0], ap = p - triangle[0];
  const Vector3d normal = ab.cross(ac);
  // barycentric coordinates of the foot of p on the plane, times the squared normal
  const double square = normal.squaredNorm();
  const double v = normal.dot(ap.cross(ac)), w = normal.dot(ab.cross(ap));
  if (!(square > 0.0) || v <= 0.0 || w <= 0.0 || v + w >= square) return closest_of_edges(triangle, p);
  const Vector3d point = triangle[0] + (v / square) * ab + (w / square) * ac;
  const TrianglePoint face{point, (p - point).squaredNorm(), Feature::kFace, 0};
  if (square > kNeedle * ab.squaredNorm() * ac.squaredNorm()) return face;
  const TrianglePoint edge = closest_of_edges(triangle, p);
  return edge.distance_squared <= face.distance_squared ? edge : face;
}

ClosestPair closest_points(const std::array<Vector3d, 2>& p, const std::array<Vector3d, 2>& q) {
  const Vector3d u = p[1] - p[0], v = q[1] - q[0], r = p[0] - q[0];
  const double a = u.squaredNorm(), e = v.squaredNorm(), b = u.dot(v), c = u.dot(r), f = v.dot(r);
  double s = 0.0, t = 0.0;
  if (a > 0.0 && e > 0.0) {
    const double determinant = a * e - b * b;
    if (determinant > 0.0) s = std::clamp((b * f - c * e) / determinant, 0.0, 1.0);
    t = (b * s + f) / e;
    if (!(t >= 0.0 && t <= 1.0)) {
      t = std::clamp(t, 0.0, 1.0);
      s = std::clamp((b * t - c) / a, 0.0, 1.0);
    }
  } else if (a > 0.0) {
    s = std::clamp(-c / a, 0.0, 1.0);
  } else if (e > 0.0) {
    t = std::clamp(f / e, 0.0, 1.0);
  }
  const Vector3d x = p[0] + s * u, y = q[0] + t * v;
  return {x, y, (x - y).squaredNorm()};
}

std::optional<double> ray_hit(const Triangle& triangle, const Vector3d& origin, const Vector3d& direction,
                              double limit) {
  const Vector3d ab = triangle[1] - triangle[0], ac = triangle[2] - triangle[0], to = origin - triangle[0];
  const Vector3d across = direction.cross(ac);
  const double determinant = ab.dot(across);
  if (!(std::abs(determinant) > kFlat * ab.norm() * across.norm())) return std::nullopt;
  const Vector3d along = to.cross(ab);
  const double u = to.dot(across) / determinant, v = direction.dot(along) / determinant;
  const double t = ac.dot(along) / determinant;
  if (!(u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0 && t <= limit)) return std::nullopt;
  return t;
}

ClosestPair closest_points(const Triangle& a, const Triangle& b) {
  ClosestPair best{{}, {}, std::numeric_limits<double>::infinity()};
  for (int i = 0; i < 3; ++i) {
    const std::array<Vector3d, 2> edge_a{a[i], a[(i + 1) % 3]}, edge_b{b[i], b[(i + 1) % 3]};
    for (int j = 0; j < 3; ++j) keep_nearer(best, closest_points(edge_a, {b[j], b[(j + 1) % 3]}));
    const TrianglePoint on_b = closest_point(b, a[i]), on_a = closest_point(a, b[i]);
    keep_nearer(best, {a[i], on_b.point, on_b.distance_squared});
    keep_nearer(best, {on_a.point, b[i], on_a.distance_squared});
    if (const auto t = ray_hit(b, edge_a[0], edge_a[1] - edge_a[0], 1.0)) {
      const Vector3d x = edge_a[0] + *t * (edge_a[1] - edge_a[0]);
      const TrianglePoint foot = closest_point(b, x);
      keep_nearer(best, {x, foot.point, foot.distance_squared});
    }
    if (const auto t = ray_hit(a, edge_b[0], edge_b[1] - edge_b[0], 1.0)) {
      const Vector3d x = edge_b[0] + *t * (edge_b[1] - edge_b[0]);
      const TrianglePoint foot = closest_point(a, x);
      keep_nearer(best, {foot.point, x, foot.distance_squared});
    }
  }
  // what is only rounding away from meeting meets if the overlap test says so
  const double size = (a[1] - a[0]).squaredNorm() + (a[2] - a[0]).squaredNorm() +
                      (b[1] - b[0]).squaredNorm() + (b[2] - b[0]).squaredNorm();
  if (best.distance_squared <= kTouch * size && overlap(a, b)) best.distance_squared = 0.0;
  return best;
}

}  // namespace feder
