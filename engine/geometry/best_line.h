#pragma once

#include <array>
#include <span>

#include "engine/geometry/triangle_mesh.h"

namespace feder {

/// First and second moments of points (each of weight 1) or of a surface (weight: its area [m^2]).
struct Spread {
  double weight = 0.0;
  Vector3d mean = Vector3d::Zero();  ///< [m]
  Matrix3d covariance =
      Matrix3d::Zero();  ///< sum of weight (p - mean)(p - mean)^T, not divided by the weight
};

/// At least one point. Misuse: none, or a covariance that is not finite.
Spread point_spread(std::span<const Vector3d> points);

/// Of the area of some triangles of a mesh, or of all: independent of how finely the surface is cut. Weight 0
/// where they have no area. Misuse: as above, an index out of range is not checked.
Spread surface_spread(const TriangleMesh& mesh, std::span<const int> triangles);
Spread surface_spread(const TriangleMesh& mesh);

/// What an axis is to the sum of squared distances |p x v|^2 over all directions v. `degenerate`: the second
/// difference towards another axis is zero to rounding, the axis is one of many.
enum class AxisKind { kMinimum, kSaddle, kMaximum, kDegenerate };

/// The three critical axes of f(v) = sum |p x v|^2, |v| = 1; the first one is the best line through the mean.
struct CriticalAxes {
  Matrix3d axes;              ///< columns; a rotation
  Vector3d squared_distance;  ///< f of each, ascending, >= 0
  std::array<AxisKind, 3> kind;
};

/// From a symmetric positive semidefinite covariance; only its lower triangle is read. Misuse: not finite.
CriticalAxes critical_axes(const Matrix3d& covariance);

/// The line through `point` along `direction` with the least sum of squared distances.
struct Line {
  Vector3d point, direction;  ///< [m], unit
};
Line best_line(std::span<const Vector3d> points);

}  // namespace feder
