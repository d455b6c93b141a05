// Random pairs of triangles in all the positions that make a predicate err.
#pragma once

#include "engine/geometry/triangle_overlap.h"
#include "tests/engine/geometry/box_pairs.h"

namespace feder::test {

struct TrianglePair {
  Triangle a, b;
};

enum class TriangleCase {
  kGeneric,
  kPiercing,
  kCoplanarExact,
  kCoplanarRounded,
  kNearlyCoplanar,
  kSharedVertex,
  kSharedEdge,
  kVertexOnFace,
  kEdgeOnEdge,
  kSegment,
  kPoint,
  kNeedle,
  kSmallOnLarge,
  kLattice,
  kCount
};

inline Triangle random_triangle(Random& random, double size = 1.0) {
  const Vector3d p = random.vector(size), q = random.vector(size);
  return {p, q, random.vector(size)};
}

inline Vector3d point_of(Random& random, const Triangle& t) {
  double u = random.uniform(0.0, 1.0), v = random.uniform(0.0, 1.0);
  if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
  return t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]);
}

inline Vector3d lattice_point(Random& random, int size) {
  const double x = random.below(size), y = random.below(size);
  return {x, y, static_cast<double>(random.below(size))};
}

/// 0, or 10^-16 to 10^-3 of either sign.
inline double near_zero(Random& random) {
  return random.below(3) ? random_sign(random) * random_size(random, -16.0, -3.0) : 0.0;
}

/// b's corner brought to point x, but for a near-zero step along the normal of a or along anything.
inline void bring(Random& random, const Triangle& a, Triangle& b, const Vector3d& from, const Vector3d& to) {
  const Vector3d normal = (a[1] - a[0]).cross(a[2] - a[0]);
  Vector3d direction = random.below(2) ? normal : random.vector();
  if (direction.norm() > 0.0) direction.normalize();
  const Vector3d shift = to - from + near_zero(random) * direction;
  for (Vector3d& p : b) p += shift;
}

inline TrianglePair random_triangle_pair(Random& random, TriangleCase kind) {
  TrianglePair pair{random_triangle(random), random_triangle(random)};
  auto& [a, b] = pair;
  switch (kind) {
    case TriangleCase::kGeneric:
      break;
    case TriangleCase::kPiercing:
      bring(random, a, b, 0.5 * (b[0] + b[1]), point_of(random, a));
      break;
    case TriangleCase::kCoplanarExact: {
      const int axis = random.below(3);
      for (Triangle* t : {&a, &b})
        for (Vector3d& p : *t) p[axis] = 0.25;
      break;
    }
    case TriangleCase::kCoplanarRounded:
      for (Vector3d& p : b) p = a[0] + random.uniform() * (a[1] - a[0]) + random.uniform() * (a[2] - a[0]);
      break;
    case TriangleCase::kNearlyCoplanar:
      for (Vector3d& p : b)
        p = a[0] + random.uniform() * (a[1] - a[0]) + random.uniform() * (a[2] - a[0]) +
            near_zero(random) * random.vector();
      break;
    case TriangleCase::kSharedVertex:
      b[random.below(3)] = a[random.below(3)];
      break;
    case TriangleCase::kSharedEdge:
      b[1] = a[random.below(2)];
      b[2] = a[2];
      if (random.below(2)) b[0] = a[0] + a[1] - a[2] + near_zero(random) * random.vector();
      break;
    case TriangleCase::kVertexOnFace:
      bring(random, a, b, b[0], point_of(random, a));
      break;
    case TriangleCase::kEdgeOnEdge:
      bring(random, a, b, b[0] + random.uniform(0, 1) * (b[1] - b[0]),
            a[1] + random.uniform(0, 1) * (a[2] - a[1]));
      break;
    case TriangleCase::kSegment:
      b[2] = random.below(2) ? b[1] : Vector3d(b[0] + random.uniform(0, 2) * (b[1] - b[0]));
      if (random.below(2)) a[2] = 0.5 * (a[0] + a[1]);
      bring(random, a, b, 0.5 * (b[0] + b[1]), 0.5 * (a[0] + point_of(random, a)));
      break;
    case TriangleCase::kPoint:
      b[1] = b[2] = b[0];
      if (random.below(3) == 0) a[1] = a[0];
      bring(random, a, b, b[0], random.below(2) ? a[0] : point_of(random, a));
      break;
    case TriangleCase::kNeedle:
      b[2] = b[1] + random_size(random, -14.0, -2.0) * random.vector();
      if (random.below(2)) a[2] = a[0] + random_size(random, -14.0, -2.0) * random.vector();
      bring(random, a, b, b[random.below(3)], random.below(2) ? a[random.below(3)] : point_of(random, a));
      break;
    case TriangleCase::kSmallOnLarge:
      b = random_triangle(random, random_size(random, -8.0, -1.0));
      bring(random, a, b, b[0], point_of(random, a));
      break;
    case TriangleCase::kLattice: {
      const int size = 2 + random.below(4);
      for (Triangle* t : {&a, &b})
        for (Vector3d& p : *t) p = lattice_point(random, size);
      break;
    }
    case TriangleCase::kCount:
      break;
  }
  if (random.below(4) == 0) {  // any scale, any place
    const double scale = random_size(random, -6.0, 6.0);
    const Vector3d shift = random.vector(scale * random_size(random, -2.0, 2.0));
    for (Triangle* t : {&a, &b})
      for (Vector3d& p : *t) p = scale * p + shift;
  }
  if (random.below(2)) std::swap(a, b);
  return pair;
}

}  // namespace feder::test
