// Boxes along the world axes (notes A3, A4): min and max per axis; disjoint if and only if disjoint on one
// axis.
#pragma once

#include <algorithm>
#include <limits>
#include <span>

#include "engine/check.h"
#include "engine/geometry/bounding_volumes.h"

namespace feder {

/// Contains nothing: merging it with a box gives that box.
inline Aabb empty_aabb() {
  const Vector3d infinity = Vector3d::Constant(std::numeric_limits<double>::infinity());
  return {infinity, -infinity};
}

inline bool is_empty(const Aabb& box) {
  return (box.min.array() > box.max.array()).any();
}

inline Aabb merged(const Aabb& a, const Aabb& b) {
  return {a.min.cwiseMin(b.min), a.max.cwiseMax(b.max)};
}

inline Aabb merged(const Aabb& box, const Vector3d& point) {
  return {box.min.cwiseMin(point), box.max.cwiseMax(point)};
}

/// Smallest box; of no points the empty one. Misuse: a coordinate that is not finite.
inline Aabb fit_aabb(std::span<const Vector3d> points) {
  Aabb box = empty_aabb();
  for (const Vector3d& p : points) {
    FEDER_CHECK(p.allFinite(), "a point to enclose is not finite");
    box = merged(box, p);
  }
  return box;
}

/// Touching counts as overlap; an empty box overlaps nothing.
inline bool overlap(const Aabb& a, const Aabb& b) {
  return a.min[0] <= b.max[0] && b.min[0] <= a.max[0] && a.min[1] <= b.max[1] && b.min[1] <= a.max[1] &&
         a.min[2] <= b.max[2] && b.min[2] <= a.max[2];
}

/// [m^3]; 0 if empty.
inline double volume(const Aabb& box) {
  return is_empty(box) ? 0.0 : (box.max - box.min).prod();
}

/// [m^2]; 0 if empty.
inline double surface_area(const Aabb& box) {
  if (is_empty(box)) return 0.0;
  const Vector3d edge = box.max - box.min;
  return 2.0 * (edge[0] * edge[1] + edge[1] * edge[2] + edge[2] * edge[0]);
}

/// The same in any dimension, d x 1 each.
struct Bounds {
  VectorXd min, max;
};

/// Points are the columns of a d x n matrix, n >= 1. Misuse: none, or one that is not finite.
inline Bounds fit_bounds(const Eigen::MatrixXd& points) {
  FEDER_CHECK(points.cols() > 0 && points.allFinite(), "bounds need at least one point, all finite");
  return {points.rowwise().minCoeff(), points.rowwise().maxCoeff()};
}

inline bool overlap(const Bounds& a, const Bounds& b) {
  return (a.min.array() <= b.max.array()).all() && (b.min.array() <= a.max.array()).all();
}

}  // namespace feder
