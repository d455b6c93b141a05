#pragma once

#include "models/model.h"

namespace feder {

/// A ladder (a bar with round ends, at rest at the start) leans against the wall x = 0 and stands on the
/// floor y = 0. Exact where friction holds it, and between smooth surfaces up to the moment when the top
/// leaves the wall.
struct Ladder {
  double length = 2.0;          ///< between the centres of its ends [m]
  double radius = 0.02;         ///< of the bar and its ends [m]
  double mass = 5.0;            ///< [kg]
  double angle = 1.2;           ///< from the floor [rad]
  double floor_friction = 0.0;  ///< Coulomb's mu
  double wall_friction = 0.0;   ///< Coulomb's mu
  double gravity = 9.81;        ///< along -y [m/s^2]
};

/// The floor friction from which on it stands: for a thin ladder 1/(2 tan(angle) + wall_friction).
double ladder_threshold(const Ladder& options);
/// Between smooth surfaces the top leaves the wall when its height (of the centre of the end above that of
/// the foot) is 2/3 of what it was: the angle [rad] and the moment [s].
double ladder_leaving_angle(const Ladder& options);
double ladder_leaving_time(const Ladder& options);

Model make_ladder(const Ladder& options = {});
ModelInfo ladder_model();

}  // namespace feder
