// Overlap of boxes by separating axes (notes A10, A11): with r(v) = sum half_i |v . a_i| two boxes are apart
// if and only if |v . (c_B - c_A)| > r_A(v) + r_B(v) for one of v in {a_i}, {b_j}, {a_i x b_j}.
// Any v proves separation, so the question is only how exactly an axis must be known to find it. Edges at an
// angle s give |v| = s with an absolute error of eps: its direction is off by eps / s and a gap of sqrt(eps)
// goes unseen. Below s = kParallel the cross product is therefore computed to full relative accuracy; above
// it the rounding of the unnormalised test, kRounding, amounts to less than 1e-12 of the boxes. a_i = +-b_j
// exactly: no axis, skipped.
#include "engine/geometry/box_overlap.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "engine/check.h"
#include "engine/geometry/accurate_vectors.h"

namespace feder {
namespace {

// Of |centre_b - centre_a| + all half edges: bounds the error of any of the 15 differences.
constexpr double kRounding = 4e-15;
constexpr double kParallel = 1e-2;

double dot(const Vector3d& a, const Vector3d& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

double size_of(const Obb& a, const Obb& b, const Vector3d& t) {
  return t.cwiseAbs().sum() + (a.half.sum() + b.half.sum());
}

// |v . t| - r_A(v) - r_B(v)
double gap_along(const Vector3d& v, const Obb& a, const Obb& b, const Vector3d& t) {
  return std::abs(dot(v, t)) - (projection_radius(a, v) + projection_radius(b, v));
}

// a_i x b_j as a unit vector, or 0 where they are parallel.
Vector3d edge_axis(const Obb& a, const Obb& b, int i, int j) {
  const Vector3d v = accurate_cross(a.axes.col(i), b.axes.col(j));
  const double length = v.norm();
  return length > 0.0 ? Vector3d(v / length) : Vector3d::Zero();
}

// The order in which a pair is looked at does not depend on the order it is given in.
bool in_order(const Vector3d& t) {
  return t[0] != 0.0 ? t[0] > 0.0 : t[1] != 0.0 ? t[1] > 0.0 : t[2] >= 0.0;
}

// Is axis v, of the same gap as the best one, the one to take? Independent of the order of the boxes.
bool precedes(const Vector3d& v, const Vector3d& best) {
  const double sign_v = in_order(v) ? 1.0 : -1.0, sign_best = in_order(best) ? 1.0 : -1.0;
  return in_order(sign_v * v - sign_best * best);
}

bool overlap_in_order(const Obb& a, const Obb& b, const Vector3d& t) {
  const double rounding = kRounding * size_of(a, b, t);
  double R[3][3], A[3][3], ta[3];

  // axes of a
  for (int i = 0; i < 3; ++i) {
    const Vector3d axis = a.axes.col(i);
    ta[i] = dot(axis, t);
    for (int j = 0; j < 3; ++j) {
      R[i][j] = dot(axis, b.axes.col(j));
      A[i][j] = std::abs(R[i][j]);
    }
    const double rb = b.half[0] * A[i][0] + b.half[1] * A[i][1] + b.half[2] * A[i][2];
    if (std::abs(ta[i]) - (a.half[i] + rb) > rounding) return false;
  }
  // axes of b
  for (int j = 0; j < 3; ++j) {
    const double tb = ta[0] * R[0][j] + ta[1] * R[1][j] + ta[2] * R[2][j];
    const double ra = a.half[0] * A[0][j] + a.half[1] * A[1][j] + a.half[2] * A[2][j];
    if (std::abs(tb) - (ra + b.half[j]) > rounding) return false;
  }
  // edge pairs, v = a_i x b_j not normalised
  constexpr int kNext[3] = {1, 2, 0}, kLast[3] = {2, 0, 1};
  for (int i = 0; i < 3; ++i) {
    const int i1 = kNext[i], i2 = kLast[i];
    for (int j = 0; j < 3; ++j) {
      const int j1 = kNext[j], j2 = kLast[j];
      const double distance = std::abs(ta[i2] * R[i1][j] - ta[i1] * R[i2][j]);
      const double ra = a.half[i1] * A[i2][j] + a.half[i2] * A[i1][j];
      const double rb = b.half[j1] * A[i][j2] + b.half[j2] * A[i][j1];
      const double gap = distance - (ra + rb);
      if (gap > rounding) return false;
      const double squared_sine = A[i1][j] * A[i1][j] + A[i2][j] * A[i2][j];
      if (gap > -rounding && squared_sine < kParallel * kParallel &&
          gap_along(edge_axis(a, b, i, j), a, b, t) > rounding)
        return false;
    }
  }
  return true;
}

}  // namespace

double projection_radius(const Obb& box, const Vector3d& v) {
  return box.half[0] * std::abs(dot(v, box.axes.col(0))) + box.half[1] * std::abs(dot(v, box.axes.col(1))) +
         box.half[2] * std::abs(dot(v, box.axes.col(2)));
}

bool overlap(const Obb& a, const Obb& b) {
  const Vector3d t = b.centre - a.centre;
  return in_order(t) ? overlap_in_order(a, b, t) : overlap_in_order(b, a, -t);
}

BoxSeparation separation(const Obb& a, const Obb& b) {
  const Vector3d t = b.centre - a.centre;
  BoxSeparation best;
  bool found = false;
  const auto consider = [&](const Vector3d& v, int index) {
    const double gap = gap_along(v, a, b, t);
    if (found && (gap < best.gap || (gap == best.gap && !precedes(v, best.axis)))) return;
    best = {gap, v, index};
    found = true;
  };
  for (int i = 0; i < 3; ++i) consider(a.axes.col(i), i);
  for (int j = 0; j < 3; ++j) consider(b.axes.col(j), 3 + j);

  // edge pairs against the best face, then against each other
  const BoxSeparation face = best;
  found = false;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const Vector3d v = edge_axis(a, b, i, j);
      if (!v.isZero(0.0)) consider(v, 6 + 3 * i + j);
    }
  if (!found || best.gap <= face.gap + kRounding * size_of(a, b, t)) best = face;
  if (dot(best.axis, t) < 0.0) best.axis = -best.axis;
  return best;
}

bool overlap(const Sphere& a, const Sphere& b) {
  return a.radius >= 0.0 && b.radius >= 0.0 && (b.centre - a.centre).norm() <= a.radius + b.radius;
}

bool overlap(const Sphere& sphere, const Aabb& box) {
  if (sphere.radius < 0.0 || (box.min.array() > box.max.array()).any()) return false;
  const Vector3d nearest = sphere.centre.cwiseMax(box.min).cwiseMin(box.max);
  return (sphere.centre - nearest).norm() <= sphere.radius;
}

bool overlap(const Sphere& sphere, const Obb& box) {
  const Vector3d local = box.axes.transpose() * (sphere.centre - box.centre);
  return sphere.radius >= 0.0 && (local.cwiseAbs() - box.half).cwiseMax(0.0).norm() <= sphere.radius;
}

double gap(const Obb& box, const Plane& half_space) {
  const double length = half_space.normal.norm();
  FEDER_CHECK(length > 0.0 && std::isfinite(length), "the normal of a plane is 0 or not finite");
  const double height = dot(half_space.normal, box.centre) - half_space.offset;
  return (height - projection_radius(box, half_space.normal)) / length;
}

bool overlap(const Obb& box, const Plane& plane) {
  const double height = dot(plane.normal, box.centre) - plane.offset;
  return std::abs(height) <= projection_radius(box, plane.normal);
}

}  // namespace feder
