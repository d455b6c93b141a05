#pragma once

#include "engine/system.h"
#include "models/model.h"

namespace feder {

/// A rotation whose third column is the unit vector n: turns half spaces, capsules and tori along it.
Matrix3d axes_along(const Vector3d& n);

/// A fixed half space below the plane through `point` with outward unit normal n.
void add_plane(SystemBuilder& builder, const Vector3d& point, const Vector3d& n, const Surface& surface);

/// How far a body has moved and turned about an axis that is fixed in the world.
struct BodyMotion {
  Vector3d shift = Vector3d::Zero();     ///< of its centre, from the start [m]
  Vector3d velocity = Vector3d::Zero();  ///< of its centre [m/s]
  double angle = 0.0;                    ///< from the start [rad]
  double rate = 0.0;                     ///< [rad/s]
};
/// The start (by exact motions: bitwise where angle and shift are 0) with body b moved so at time t.
State moved_body(const State& start, const Body& b, double t, const Vector3d& axis, const BodyMotion& motion);

// Of all bodies and particles, about the origin.
Conserved conserved_momentum(const std::string& name, int axis);
Conserved conserved_angular_momentum(const std::string& name, int axis);

}  // namespace feder
