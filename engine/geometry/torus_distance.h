#pragma once

#include "engine/state.h"

namespace feder {

/// A circle in space. radius 0 is a point.
struct Circle {
  Vector3d centre = Vector3d::Zero();   ///< [m]
  Vector3d normal = Vector3d::UnitZ();  ///< of the plane it lies in; not 0, need not be unit
  double radius = 0.0;                  ///< >= 0 [m]
};

/// All points within `minor` of a circle.
struct Torus {
  Circle circle;
  double minor = 0.0;  ///< tube radius, >= 0 [m]
};

struct CircleDistance {
  double distance = 0.0;                ///< [m]
  Vector3d point_a = Vector3d::Zero();  ///< a pair of closest points; there may be more [m]
  Vector3d point_b = Vector3d::Zero();
};

/// To 1e-12 of the circles' size. The same for (b, a) to the last bit. Misuse: a normal of 0, a radius < 0,
/// numbers that are not finite.
CircleDistance distance(const Circle& a, const Circle& b);

/// Of the surfaces: > 0 apart, <= 0 they overlap (touching counts) and the tubes are this deep in each other
/// [m].
double gap(const Torus& a, const Torus& b);
/// Touching counts, also where rounding alone tells it from a gap.
bool overlap(const Torus& a, const Torus& b);

}  // namespace feder
