#pragma once

#include "engine/status.h"
#include "solvers/joint_step.h"

namespace feder {

/// What a redundant arm does with the freedom its task leaves.
enum class Preference {
  kMiddle,         ///< joints in the middle of their limits: -1/2 sum ((q - middle) / range)^2 grows
  kManipulability  ///< away from singular poses: log sqrt(det A A^T) grows
};
double preference(const KinematicMap& map, double length, Preference which, const VectorXd& q);
/// Its gradient by q, of manipulability by central differences.
VectorXd preference_gradient(const KinematicMap& map, double length, Preference which, const VectorXd& q);

struct SettleOptions {
  Preference which = Preference::kMiddle;
  double length = 1.0;       ///< metres a radian weighs
  double tolerance = 1e-11;  ///< of the pose, kept throughout [m], [rad]
  double first_turn = 0.1;   ///< largest change of a joint in one move [rad], [m]
  int most_moves = 1000;
};

/// Moves q along z + A^T y (z uphill, A x = 0) while the preference grows, the pose and the limits kept; the
/// arm never leaves its self-motion manifold by more than the tolerance. q must reach the target.
/// kLimitReached where the moves run out; q is then the best so far. InputError for options out of range.
Status settle(const KinematicMap& map, const Pose& target, VectorXd& q, const SettleOptions& options = {});

}  // namespace feder
