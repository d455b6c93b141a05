#pragma once

#include "engine/state.h"

namespace feder {

/// Closed ball. radius < 0: empty [m].
struct Sphere {
  Vector3d centre = Vector3d::Zero();
  double radius = -1.0;
};

/// Box along the world axes, closed; empty where min > max [m].
struct Aabb {
  Vector3d min, max;
};

/// Box along axes of its own (columns, a rotation), closed [m].
struct Obb {
  Vector3d centre;
  Matrix3d axes;
  Vector3d half;  ///< half edges, >= 0
};

}  // namespace feder
