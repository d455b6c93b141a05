// Random pairs of boxes, half of them close to a degenerate case.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "engine/geometry/bounding_volumes.h"
#include "tests/support/random.h"

namespace feder::test {

struct BoxPair {
  Obb a, b;
};

inline Matrix3d random_rotation(Random& random) {
  constexpr double pi = std::numbers::pi;
  return Eigen::AngleAxisd(random.uniform(-pi, pi), random.vector().normalized()).toRotationMatrix();
}

/// Logarithmically between 10^low and 10^high.
inline double random_size(Random& random, double low, double high) {
  return std::pow(10.0, random.uniform(low, high));
}

inline double random_sign(Random& random) {
  return random.below(2) ? 1.0 : -1.0;
}

/// Generic halves, or flat, or thin, or a needle; a point now and then.
inline Vector3d random_half(Random& random, bool degenerate) {
  Vector3d half(random.uniform(0.05, 1.0), random.uniform(0.05, 1.0), random.uniform(0.05, 1.0));
  if (!degenerate) return half;
  const int axis = random.below(3);
  switch (random.below(8)) {
    case 0:
      half[axis] = 0.0;
      break;
    case 1:
      half[axis] = random_size(random, -12.0, -3.0);
      break;
    case 2:
      half[axis] = random_size(random, 1.0, 3.0);
      break;
    case 3:
      half[axis] = half[(axis + 1) % 3] = 0.0;
      break;
    case 4:
      half = Vector3d::Constant(random.below(4) ? half[0] : 0.0);
      break;
    default:
      break;
  }
  return half;
}

/// The axes of b: like those of a, permuted, turned about one of them, nearly parallel, or any.
inline Matrix3d related_axes(Random& random, const Matrix3d& axes) {
  const double angle = random.uniform(-3.0, 3.0), small = random_size(random, -15.0, -1.0);
  const Vector3d about = random.below(2) ? Vector3d(axes.col(random.below(3))) : random.vector().normalized();
  Matrix3d permuted = axes;
  switch (random.below(6)) {
    case 0:
      return axes;
    case 1:
      permuted << axes.col(1), axes.col(2), axes.col(0);
      return permuted;
    case 2:
      return Eigen::AngleAxisd(angle, axes.col(random.below(3))).toRotationMatrix() * axes;
    case 3:
    case 4:
      return Eigen::AngleAxisd(small, about).toRotationMatrix() * axes;
    default:
      return random_rotation(random);
  }
}

/// A corner, or a point of an edge, or of a face.
inline Vector3d boundary_point(Random& random, const Obb& box, int dimension) {
  Vector3d local =
      box.half.cwiseProduct(Vector3d(random_sign(random), random_sign(random), random_sign(random)));
  const int axis = random.below(3);
  for (int k = 0; k < dimension; ++k) local[(axis + k) % 3] *= random.uniform(0.0, 1.0);
  return box.centre + box.axes * local;
}

/// b moved so that a boundary point of each coincides, but for a step along a direction that may part them.
inline void touch(Random& random, const Obb& a, Obb& b) {
  const double size = a.half.sum() + b.half.sum();
  const double step = random.below(4) ? random_sign(random) * random_size(random, -16.0, -2.0) * size : 0.0;
  Vector3d direction;
  Vector3d from, to;
  if (random.below(2)) {  // edge i of a on edge j of b
    direction = a.axes.col(random.below(3)).cross(b.axes.col(random.below(3)));
    if (direction.norm() > 0.0) direction.normalize();
    from = boundary_point(random, b, 1);
    to = boundary_point(random, a, 1);
  } else {  // any feature of b on a face of a
    const int axis = random.below(3);
    const Vector3d normal = a.axes.col(axis);
    direction = normal;
    Vector3d local = a.half.cwiseProduct(random.vector());
    local[axis] = a.half[axis];
    to = a.centre + a.axes * local;
    Vector3d lowest;
    for (int k = 0; k < 3; ++k) lowest[k] = normal.dot(b.axes.col(k)) > 0.0 ? -b.half[k] : b.half[k];
    from = b.centre + b.axes * lowest;
  }
  b.centre += to - from + step * direction;
}

inline BoxPair random_box_pair(Random& random) {
  const bool degenerate = random.below(2);
  BoxPair pair;
  pair.a = {random.vector(), random_rotation(random), random_half(random, degenerate)};
  pair.b = {random.vector(2.0), random_rotation(random), random_half(random, degenerate)};
  if (!degenerate) return pair;
  if (random.below(4) == 0) pair.a.axes.setIdentity();
  pair.b.axes = related_axes(random, pair.a.axes);
  if (random.below(8)) touch(random, pair.a, pair.b);
  // any scale, any place
  const double scale = random.below(2) ? 1.0 : random_size(random, -3.0, 3.0);
  for (Obb* box : {&pair.a, &pair.b}) {
    box->half *= scale;
    box->centre *= scale;
  }
  return pair;
}

}  // namespace feder::test
