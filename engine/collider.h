#pragma once

#include "engine/anchor_rows.h"
#include "engine/geometry/shape.h"

namespace feder {

struct System;

/// What a solid is like where it is touched. Two surfaces meet with the geometric mean of their friction and
/// the larger of their restitutions.
struct Surface {
  double friction = 0.0;     ///< Coulomb's mu >= 0
  double restitution = 0.0;  ///< e in [0, 1]
};

/// A solid shape that moves with a body, a particle or a world point.
struct Collider {
  Anchor at;  ///< origin of the shape's axes
  Shape shape;
  Surface surface;
  Matrix3d rotation = Matrix3d::Identity();  ///< shape axes -> axes of the body, of the world at nodes
  int group = 0;  ///< colliders of one group, other than 0, pass through each other

  Place place = {};    ///< resolved
  bool fixed = false;  ///< holds no unknowns
  void resolve(const System& system);
  Pose pose(const double* q) const;
  double reach() const;  ///< largest distance of a point of the shape from `at`, infinite for half spaces [m]
};

}  // namespace feder
