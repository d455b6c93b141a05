// Separating plane of convex polytopes (notes A9) by the distance algorithm of Gilbert, Johnson and Keerthi
// (1988): A and B are disjoint if and only if 0 is outside B - A; the point v of B - A closest to 0 is found
// by going from simplex to simplex, adding the corner w furthest against v. Disjoint is what a direction
// proves:
//   min over A, B of v . (b - a) > 0, strictly: two closed half spaces would admit touching.
// Near contact the difference v itself is all rounding. Directions are therefore taken from the simplex: the
// normal of its face, the perpendicular (e x w) x e of its edge, from exact differences and accurate cross
// products.
#include "engine/geometry/separating_plane.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "engine/check.h"
#include "engine/geometry/aabb.h"
#include "engine/geometry/accurate_vectors.h"

namespace feder {
namespace {

// Error of a gap on the grid, in units of its length.
constexpr double kRounding = 16.0 * std::numeric_limits<double>::epsilon();
// Steps go strictly down, 10 to 30 of them in practice; this ends what rounding would keep going.
constexpr int kMostSteps = 1000;

// A corner of B - A.
struct Corner {
  int a = 0, b = 0;
  Vector3d w = Vector3d::Zero();
};

// A simplex with 0 over its inside: distance, the direction from 0, and weights of the closest point (not
// scaled).
struct Feature {
  std::array<Corner, 4> corner;
  std::array<double, 4> weight{};
  int size = 0;
  double distance = std::numeric_limits<double>::infinity();
  Vector3d direction = Vector3d::Zero();
};

// Fills in the rest from the corners; false if 0 is beside the simplex, by more than the rounding of the
// corners.
bool measure(Feature& f) {
  const Vector3d &w0 = f.corner[0].w, &w1 = f.corner[1].w, &w2 = f.corner[2].w, &w3 = f.corner[3].w;
  if (f.size == 1) {
    f.weight = {1.0};
    f.distance = w0.norm();
    f.direction = w0;
    return true;
  }
  if (f.size == 2) {
    const Vector3d e = w1 - w0, across = accurate_cross(e, w0);
    f.weight = {w1.dot(e), -w0.dot(e)};
    f.distance = across.norm() / e.norm();
    f.direction = accurate_cross(across, e);
    const double rounding = kRounding * e.norm();
    return f.weight[0] > -rounding * w1.norm() && f.weight[1] > -rounding * w0.norm();
  }
  const Vector3d s0 = accurate_cross(w1, w2), s1 = accurate_cross(w2, w0), s2 = accurate_cross(w0, w1);
  if (f.size == 3) {
    const Vector3d n = accurate_cross(w1 - w0, w2 - w0);
    const double height = n.dot(w0), rounding = kRounding * n.norm();
    f.weight = {s0.dot(n), s1.dot(n), s2.dot(n)};
    f.distance = std::abs(height) / n.norm();
    f.direction = height < 0.0 ? Vector3d(-n) : n;
    return f.weight[0] > -rounding * s0.norm() && f.weight[1] > -rounding * s1.norm() &&
           f.weight[2] > -rounding * s2.norm();
  }
  // 0 within a tetrahedron, by more than rounding: otherwise it is on a face
  f.weight = {s0.dot(w3), s1.dot(w3), s2.dot(w3), -s2.dot(w2)};
  f.distance = 0.0;
  if (f.weight[0] < 0.0)
    for (double& weight : f.weight) weight = -weight;
  const double rounding = kRounding * w3.norm();
  return f.weight[0] > rounding * s0.norm() && f.weight[1] > rounding * s1.norm() &&
         f.weight[2] > rounding * s2.norm() && f.weight[3] > kRounding * s2.norm() * w2.norm();
}

// The face of the simplex closest to 0 that has its last corner, which is the one 0 was missing. Of those
// that are equally close the largest: its direction sees all their corners, so that none is dropped only to
// be found again.
Feature closest_feature(const std::array<Corner, 4>& corner, int size) {
  Feature best;
  for (int others = 0; others < 1 << (size - 1); ++others) {
    Feature f;
    for (int k = 0; k < size; ++k)
      if (k == size - 1 || others >> k & 1) f.corner[f.size++] = corner[k];
    if (!measure(f)) continue;
    const double closer = best.distance - f.distance;
    if (closer > kRounding || (closer > -kRounding && f.size > best.size)) best = f;
  }
  return best;
}

// Furthest corners of A and B towards each other.
Corner support(const std::vector<Vector3d>& a, const std::vector<Vector3d>& b, const Vector3d& v) {
  Corner out;
  double high = v.dot(a[0]), low = v.dot(b[0]);
  for (std::size_t i = 1; i < a.size(); ++i)
    if (const double s = v.dot(a[i]); s > high) high = s, out.a = static_cast<int>(i);
  for (std::size_t i = 1; i < b.size(); ++i)
    if (const double s = v.dot(b[i]); s < low) low = s, out.b = static_cast<int>(i);
  out.w = b[out.b] - a[out.a];
  return out;
}

bool contains(const Feature& f, const Corner& corner) {
  for (int k = 0; k < f.size; ++k)
    if (f.corner[k].w == corner.w) return true;
  return false;
}

std::vector<Vector3d> on_grid(const Grid& grid, std::span<const Vector3d> points) {
  std::vector<Vector3d> out;
  out.reserve(points.size());
  for (const Vector3d& p : points) out.push_back(grid(p));
  return out;
}

}  // namespace

ConvexSeparation separation(std::span<const Vector3d> a, std::span<const Vector3d> b) {
  FEDER_CHECK(!a.empty() && !b.empty(), "a polytope needs at least one point");
  const Grid grid(merged(fit_aabb(a), fit_aabb(b)));
  const std::vector<Vector3d> x = on_grid(grid, a), y = on_grid(grid, b);

  // descend until the closest feature's own direction proves its distance, or 0 is inside
  Feature nearest;
  nearest.size = 1;
  nearest.corner[0].w = y[0] - x[0];
  measure(nearest);
  double gap = 0.0;
  Vector3d normal = Vector3d::Zero();
  Corner facing;
  for (int step = 0; step < kMostSteps && nearest.distance > kRounding; ++step) {
    const Vector3d v = nearest.direction.normalized();
    const Corner next = support(x, y, v);
    if (v.dot(next.w) > gap) {
      gap = v.dot(next.w);
      normal = v;
      facing = next;
    }
    if (v.dot(next.w) >= nearest.distance - kRounding || contains(nearest, next)) break;
    std::array<Corner, 4> simplex = nearest.corner;
    simplex[nearest.size] = next;
    const Feature nearer = closest_feature(simplex, nearest.size + 1);
    if (nearer.distance > nearest.distance + kRounding) break;
    nearest = nearer;
  }

  // closest points by the weights of the feature
  ConvexSeparation out;
  double sum = 0.0;
  Vector3d point_a = Vector3d::Zero(), point_b = Vector3d::Zero();
  for (int k = 0; k < nearest.size; ++k) {
    sum += nearest.weight[k];
    point_a += nearest.weight[k] * x[nearest.corner[k].a];
    point_b += nearest.weight[k] * y[nearest.corner[k].b];
  }
  out.overlap = gap <= kRounding;
  out.point_a = grid.world(point_a / sum);
  out.point_b = grid.world(point_b / sum);
  if (out.overlap) {
    out.point_a = out.point_b = 0.5 * out.point_a + 0.5 * out.point_b;
    return out;
  }
  out.distance = grid.length() * nearest.distance;
  out.normal = normal;
  out.point = grid.world(0.5 * x[facing.a] + 0.5 * y[facing.b]);
  return out;
}

}  // namespace feder
