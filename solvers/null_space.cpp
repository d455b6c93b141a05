// x = z + A^T y, A x = e: (E - J^+ J) z + J^+ e, the minimum-norm step that starts from z instead of 0.
#include "solvers/null_space.h"

#include <cmath>

#include "engine/check.h"

namespace feder {
namespace {

constexpr double kDifference = 1e-5;  // of manipulability [rad], [m]
constexpr int kCorrections = 8;
constexpr double kFloor = 1e-15;  // of gamma, of |A|^2

bool reached(const JointStep& arm, double tolerance) {
  const PoseError error = arm.pose_error();
  return error.place <= tolerance && error.angle <= tolerance;
}

// One move along z and back to the pose; false if it does not come back.
bool move(JointStep& arm, const Pose& target, const VectorXd& z, double tolerance, VectorXd& q) {
  VectorXd x, along = z;
  for (int i = 0; i < kCorrections; ++i) {
    arm.linearise(q, target);
    if (i > 0 && reached(arm, tolerance)) return true;
    if (!arm.step(q, along, kFloor * arm.matrix().squaredNorm(), x)) return false;
    arm.take(x, q);
    along.setZero();
  }
  arm.linearise(q, target);
  return reached(arm, tolerance);
}

}  // namespace

double preference(const KinematicMap& map, double length, Preference which, const VectorXd& q) {
  if (which == Preference::kMiddle) {
    const VectorXd range = map.greatest - map.least, middle = 0.5 * (map.greatest + map.least);
    return -0.5 * (q - middle).cwiseQuotient(range).squaredNorm();
  }
  JointStep arm(map, length);
  arm.linearise(q, Pose{});
  return std::log(manipulability(arm.matrix()));
}

VectorXd preference_gradient(const KinematicMap& map, double length, Preference which, const VectorXd& q) {
  if (which == Preference::kMiddle) {
    const VectorXd range = map.greatest - map.least, middle = 0.5 * (map.greatest + map.least);
    return (middle - q).cwiseQuotient(range.cwiseProduct(range));
  }
  VectorXd gradient(q.size()), at = q;
  for (int i = 0; i < q.size(); ++i) {
    auto value = [&](double offset) {
      at[i] = q[i] + offset;
      return preference(map, length, which, at);
    };
    gradient[i] = (value(kDifference) - value(-kDifference)) / (2.0 * kDifference);
    at[i] = q[i];
  }
  return gradient.allFinite() ? gradient : VectorXd::Zero(q.size());
}

Status settle(const KinematicMap& map, const Pose& target, VectorXd& q, const SettleOptions& o) {
  const std::string place = "self-motion of '" + map.name + "'";
  require_positive(place, "length", o.length, "m");
  require_tolerance(place, o.tolerance, map);
  require_positive(place, "first_turn", o.first_turn, "rad");
  JointStep arm(map, o.length);
  arm.linearise(q, target);
  if (!reached(arm, o.tolerance))
    return Status::failure(StatusCode::kRefused, "the joints do not reach the target to begin with");
  double turn = o.first_turn, value = preference(map, o.length, o.which, q);
  for (int i = 0; i < o.most_moves; ++i) {
    VectorXd z = preference_gradient(map, o.length, o.which, q), x;
    // only what the null space and the limits let through decides the length of the move
    arm.linearise(q, target);
    if (!arm.step(q, z, kFloor * arm.matrix().squaredNorm(), x)) return {};
    const double size = x.lpNorm<Eigen::Infinity>();
    if (!(size > 1e-9 * z.lpNorm<Eigen::Infinity>())) return {};
    VectorXd trial = q;
    const bool back = move(arm, target, turn / size * z, o.tolerance, trial);
    const double there = back ? preference(map, o.length, o.which, trial) : value;
    if (back && there > value) {
      const bool done = there - value <= 1e-12 * std::abs(value);
      q = trial, value = there, turn = std::min(2.0 * turn, o.first_turn);
      if (done) return {};
    } else if ((turn *= 0.25) < 1e-9) {
      return {};
    }
  }
  return Status::failure(StatusCode::kLimitReached, "the preference still grows");
}

}  // namespace feder
