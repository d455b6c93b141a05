#pragma once

#include "models/model.h"

namespace feder {

/// A ball bounces on the plane y = 0 until it rolls. Exact at all times.
struct BouncingBall {
  double height = 1.0;       ///< of its lowest point at the start [m]
  double restitution = 0.7;  ///< e in [0, 1]
  double speed = 0.0;        ///< at the start, along +x [m/s]
  double spin = 0.0;         ///< at the start, forwards [rad/s]
  double friction = 0.0;     ///< Coulomb's mu
  double mass = 1.0;         ///< [kg]
  double radius = 0.1;       ///< of the solid ball [m]
  double gravity = 9.81;     ///< along -y [m/s^2]
};

/// Time of the n-th bounce, n = 1, 2, ... [s]; n = infinity: when it has come to rest on the plane.
double bounce_time(const BouncingBall& options, double n);

Model make_bouncing_ball(const BouncingBall& options = {});
ModelInfo bouncing_ball_model();

}  // namespace feder
