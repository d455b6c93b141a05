#pragma once

#include <functional>

#include "engine/state.h"

namespace feder {

struct System;

/// A prescribed motion x(t) [m] of a world point, with its derivatives.
struct Motion {
  std::function<Vector3d(double t)> position, velocity, acceleration;
};
/// A prescribed target s(t) of a row, [m] or [rad], with its derivatives.
struct Target {
  std::function<double(double t)> value, rate, acceleration;
};
/// s(t) = start + speed t: a motor of constant velocity.
Target steady_target(double start, double speed);

/// A node that follows a motion. It has no unknowns; rows see it through its place in q and v, so that phi_t
/// is J times its velocity and no row knows the time.
struct Drive {
  int node = -1;
  Motion motion;
  bool dial = false;  ///< only x follows: the target of a row; y is the angle the row has turned so far [rad]
};

/// Puts driven nodes where they are at time t and lets dials count the turns of their rows up to q.
void place_driven_nodes(const System& system, double t, VectorXd& q);
/// Gives driven nodes their velocity at time t.
void set_driven_velocities(const System& system, double t, VectorXd& v);
/// Both, at the state's own time. Nothing to do where nothing is driven.
void drive(const System& system, State& state);
/// a <- accelerations of the driven nodes at time t, 0 elsewhere.
void driven_accelerations(const System& system, double t, VectorXd& a);

}  // namespace feder
