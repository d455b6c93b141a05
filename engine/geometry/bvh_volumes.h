#pragma once

#include <algorithm>
#include <cmath>

#include "engine/geometry/bounding_volumes.h"
#include "engine/geometry/shape.h"
#include "engine/geometry/triangle_overlap.h"

namespace feder {

// What the queries of a hierarchy ask of a volume. `slack` [m] covers the rounding of the poses: volumes that
// are closer than it count as touching.

/// The volume of `count` >= 1 triangles of a mesh from `first` on.
void fit_volume(const TriangleMesh& mesh, int first, int count, Sphere& out);
void fit_volume(const TriangleMesh& mesh, int first, int count, Aabb& out);
void fit_volume(const TriangleMesh& mesh, int first, int count, Obb& out);

/// Squared distance of a point from the volume, at most [m^2]; 0 inside.
inline double distance_squared(const Aabb& box, const Vector3d& p) {
  return (box.min - p).cwiseMax(p - box.max).cwiseMax(0.0).squaredNorm();
}
inline double distance_squared(const Sphere& ball, const Vector3d& p) {
  const double gap = std::max((p - ball.centre).norm() - ball.radius, 0.0);
  return gap * gap;
}
inline double distance_squared(const Obb& box, const Vector3d& p) {
  return ((box.axes.transpose() * (p - box.centre)).cwiseAbs() - box.half).cwiseMax(0.0).squaredNorm();
}

/// A measure by which the larger of two volumes is descended first.
inline double size_of(const Aabb& box) {
  return (box.max - box.min).squaredNorm();
}
inline double size_of(const Sphere& ball) {
  return ball.radius;
}
inline double size_of(const Obb& box) {
  return box.half.squaredNorm();
}

/// Second frame in the first: a point x of it is at rotation x + position.
struct Relative {
  Matrix3d rotation, size;  ///< size: absolute values of the rotation
  Vector3d position;        ///< [m]
  bool turned;              ///< the rotation is not exactly the identity
  double slack;             ///< [m]

  Vector3d operator()(const Vector3d& x) const { return rotation * x + position; }
  Triangle operator()(const Triangle& t) const { return {(*this)(t[0]), (*this)(t[1]), (*this)(t[2])}; }
};
/// reach: largest distance of a point of either mesh from its origin [m].
Relative relative(const Pose& a, const Pose& b, double reach);

/// Largest distance of a point of the volume from the origin, at least [m].
double reach_of(const Sphere& ball);
double reach_of(const Aabb& box);
double reach_of(const Obb& box);

/// Gaps of two boxes along the axes of the first and of the second; the distance is at least the norm of
/// either. `centre` and `axes` of the second box are given in the frame of the first.
struct BoxGaps {
  Vector3d along_a, along_b;
};
inline BoxGaps box_gaps(const Vector3d& half_a, const Vector3d& half_b, const Vector3d& centre,
                        const Matrix3d& axes, const Matrix3d& size) {
  return {centre.cwiseAbs() - half_a - size * half_b,
          (axes.transpose() * centre).cwiseAbs() - half_b - size.transpose() * half_a};
}
BoxGaps box_gaps(const Obb& a, const Obb& b, const Relative& frame);
inline BoxGaps box_gaps(const Aabb& a, const Aabb& b, const Relative& frame) {
  const Vector3d centre = frame(0.5 * (b.min + b.max)) - 0.5 * (a.min + a.max);
  return box_gaps(0.5 * (a.max - a.min), 0.5 * (b.max - b.min), centre, frame.rotation, frame.size);
}

inline double largest(const Vector3d& x) {
  return std::max(std::max(x[0], x[1]), x[2]);
}

/// Certainly apart. False says nothing.
inline bool apart(const Aabb& a, const Aabb& b, const Relative& frame) {
  if (!frame.turned) {
    const Vector3d above = b.min + frame.position - a.max, below = a.min - b.max - frame.position;
    return largest(above.cwiseMax(below)) > frame.slack;
  }
  const Vector3d half_a = 0.5 * (a.max - a.min), half_b = 0.5 * (b.max - b.min);
  const Vector3d centre = frame(0.5 * (b.min + b.max)) - 0.5 * (a.min + a.max);
  return largest(centre.cwiseAbs() - half_a - frame.size * half_b) > frame.slack ||
         largest((frame.rotation.transpose() * centre).cwiseAbs() - half_b -
                 frame.size.transpose() * half_a) > frame.slack;
}
inline bool apart(const Sphere& a, const Sphere& b, const Relative& frame) {
  const double reach = a.radius + b.radius + frame.slack;
  return (frame(b.centre) - a.centre).squaredNorm() > reach * reach;
}
inline bool apart(const Obb& a, const Obb& b, const Relative& frame) {
  const BoxGaps gaps = box_gaps(a, b, frame);
  return largest(gaps.along_a) > frame.slack || largest(gaps.along_b) > frame.slack;
}

/// Squared distance of two volumes, at most [m^2].
template <class Box>
double distance_squared(const Box& a, const Box& b, const Relative& frame) {
  const BoxGaps gaps = box_gaps(a, b, frame);
  const double gap =
      std::sqrt(std::max(gaps.along_a.cwiseMax(0.0).squaredNorm(), gaps.along_b.cwiseMax(0.0).squaredNorm()));
  const double certain = std::max(gap - frame.slack, 0.0);
  return certain * certain;
}
inline double distance_squared(const Sphere& a, const Sphere& b, const Relative& frame) {
  const double gap = std::max((frame(b.centre) - a.centre).norm() - a.radius - b.radius - frame.slack, 0.0);
  return gap * gap;
}

/// First t >= 0 with origin + t direction within `slack` of the volume; infinity: it passes by.
double ray_entry(const Sphere& ball, const Vector3d& origin, const Vector3d& direction, double slack);
double ray_entry(const Aabb& box, const Vector3d& origin, const Vector3d& direction, double slack);
double ray_entry(const Obb& box, const Vector3d& origin, const Vector3d& direction, double slack);
double ray_slack(double reach, const Vector3d& origin);

}  // namespace feder
