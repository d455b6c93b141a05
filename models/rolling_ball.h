#pragma once

#include "models/model.h"

namespace feder {

/// A ball set down sliding on a rough plane: friction slows and spins it until it rolls. Exact.
struct RollingBall {
  double mass = 1.0;      ///< [kg]
  double radius = 0.1;    ///< [m]
  double hollow = 0.0;    ///< radius of the hole inside, as a fraction; 0: solid
  double speed = 2.0;     ///< at the start, along +x [m/s]
  double spin = 0.0;      ///< at the start, forwards: spin radius is the speed it would roll at [rad/s]
  double friction = 0.2;  ///< Coulomb's mu
  double gravity = 9.81;  ///< along -y [m/s^2]
};

/// Moment of inertia of a ball with a concentric hole over mass radius^2: 2/5 if solid, up to 2/3.
double ball_inertia_ratio(double hollow);

/// A ball on the plane: way along +x and turn forwards, and their rates. Slips until speed = radius spin.
struct Roll {
  double way = 0.0, speed = 0.0, turn = 0.0, spin = 0.0;  ///< [m, m/s, rad, rad/s]
};
struct RollingLaw {
  double radius, ratio, rub;           ///< [m, 1, m/s^2]: rub = mu g
  double slip_time(Roll start) const;  ///< [s]; infinite on a frictionless plane
  Roll after(Roll start, double t) const;
};

/// I spin + m radius v, forwards along x, of body 0: what no push through its centre and no friction at its
/// lowest point changes.
Conserved conserved_rolling_momentum(double radius);

Model make_rolling_ball(const RollingBall& options = {});
ModelInfo rolling_ball_model();

}  // namespace feder
