// Per piece: the pose at its end is the target of steps x = z + A^T y, (A A^T + gamma) y = e - A z, repeated
// to the tolerance while gamma = 0. With gamma > 0 one step is all: what is left of e is the price of bounded
// speed, |x| <= |e| / (2 sqrt gamma), and returns as the next piece's error.
#include "solvers/follow_path.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "engine/check.h"
#include "solvers/null_space.h"

namespace feder {
namespace {

constexpr int kCorrections = 10;
constexpr double kFloor = 1e-16;  // of gamma, of |A|^2

class Follower {
 public:
  Follower(const KinematicMap& map, const PathOptions& options)
      : map_(map), o_(options), arm_(map, options.length), zero_(VectorXd::Zero(map.joints())) {}

  PathPoint point(double s, const VectorXd& q, const Pose& target) {
    arm_.linearise(q, target);
    return {s, q, arm_.pose_error(), 0.0, smallest_singular_value(arm_.matrix())};
  }

  // From a point to the pose of the path at its `s`; false if a shorter piece has to be tried.
  bool piece(const PathPoint& from, const Pose& target, double seconds, PathPoint& to) {
    VectorXd q = from.q, z = null_motion(from.q, seconds), x;
    Eigen::MatrixXd first;
    for (int i = 0; i < kCorrections; ++i) {
      arm_.linearise(q, target);
      if (i == 0) first = arm_.matrix();
      if (i > 0 && within(arm_.pose_error())) break;
      const bool damped = o_.method == PathMethod::kDamped;
      const double gamma = damped ? o_.damping.gamma(smallest_singular_value(arm_.matrix())) : 0.0;
      if (!arm_.step(q, z, gamma + kFloor * first.squaredNorm(), x)) return false;
      const bool cut = damped && cut_to(std::min(o_.most_turn, o_.most_speed * seconds), x);
      arm_.take(x, q);
      z = zero_;
      if (!((q - from.q).lpNorm<Eigen::Infinity>() <= o_.most_turn)) return false;
      if (cut || gamma > 0.0) break;
    }
    const double s = to.s;
    to = point(s, q, target);
    to.speed = (q - from.q).norm() / seconds;
    if (o_.method == PathMethod::kDamped) return true;
    return within(to.error) && (arm_.matrix() - first).norm() <= from.smallest;
  }

  bool within(const PoseError& error) const {
    return error.place <= o_.tolerance && error.angle <= o_.tolerance;
  }

 private:
  static bool cut_to(double most, VectorXd& x) {
    const double size = x.lpNorm<Eigen::Infinity>();
    if (size > most) x *= most / size;
    return size > most;
  }

  VectorXd null_motion(const VectorXd& q, double seconds) const {
    if (o_.method != PathMethod::kNullSpace) return zero_;
    VectorXd z = o_.null_rate * preference_gradient(map_, o_.length, Preference::kManipulability, q);
    const double speed = z.norm();
    if (speed > o_.null_speed) z *= o_.null_speed / speed;
    return seconds * z;
  }

  const KinematicMap& map_;
  const PathOptions& o_;
  JointStep arm_;
  VectorXd zero_;
};

void check(const std::string& place, const KinematicMap& map, const VectorXd& start, const PathOptions& o) {
  if (o.pieces < 1) fail_input(place, "pieces", o.pieces, "", "at least 1");
  require_positive(place, "duration", o.duration, "s");
  require_tolerance(place, o.tolerance, map);
  require_positive(place, "length", o.length, "m");
  require_positive(place, "most_turn", o.most_turn, "rad");
  require_positive(place, "most_speed", o.most_speed, "rad/s");
  require_positive(place, "least_piece", o.least_piece, "");
  require_non_negative(place, "damping threshold", o.damping.threshold, "m");
  require_non_negative(place, "damping at a singular pose", o.damping.most, "m^2");
  require_non_negative(place, "null_rate", o.null_rate, "1/s");
  require_non_negative(place, "null_speed", o.null_speed, "rad/s");
  FEDER_CHECK(start.size() == map.joints(), "as many joint values as the arm has joints");
  for (int i = 0; i < start.size(); ++i)
    if (!(start[i] >= map.least[i] && start[i] <= map.greatest[i]))
      fail_input(place, "start of joint " + std::to_string(i + 1), start[i], "rad or m", "within its limits");
}

// Of what the path gives.
Status pose_status(const std::string& place, double s, const Pose& pose) {
  const std::string at = place + " at s = " + std::to_string(s);
  if (!pose.position.allFinite() || !pose.rotation.allFinite())
    return Status::failure(StatusCode::kNonFinite, at + ": the pose is not finite");
  if (off_rotation(pose.rotation) < kRotation) return {};
  return Status::failure(StatusCode::kInconsistent, at + ": the rotation of the pose is none");
}

}  // namespace

PathResult follow_path(const KinematicMap& map, const std::function<Pose(double s)>& path,
                       const VectorXd& start, const PathOptions& o) {
  const std::string place = "path of '" + map.name + "'";
  check(place, map, start, o);
  Follower follower(map, o);
  PathResult result;
  const Pose first = path(0.0);
  if (const Status status = pose_status(place, 0.0, first); !status.ok()) throw InputError(status.reason);
  result.points.push_back(follower.point(0.0, start, first));
  const PoseError& off = result.points[0].error;
  if (!(off.place < 1e-6 && off.angle < 1e-6))
    fail_input(place, "start", std::max(off.place, off.angle), "m or rad off the path", "less than 1e-6");
  double piece = 1.0 / o.pieces;
  while (result.points.back().s < 1.0) {
    const PathPoint& from = result.points.back();
    // rounding must leave no sliver at the end
    PathPoint to;
    to.s = from.s + piece > 1.0 - 1e-3 * piece ? 1.0 : from.s + piece;
    const Pose target = path(to.s);
    result.status = pose_status(place, to.s, target);
    if (!result.status.ok()) return result;
    if (follower.piece(from, target, (to.s - from.s) * o.duration, to)) {
      result.points.push_back(std::move(to));
      piece = std::min(2.0 * piece, 1.0 / o.pieces);
      continue;
    }
    piece *= 0.5;
    ++result.halvings;
    if (piece < o.least_piece) {
      char reason[96];
      std::snprintf(reason, sizeof reason, " cannot go on at s = %.10g: smallest singular value %.3g m",
                    from.s, from.smallest);
      result.status = Status::failure(StatusCode::kStepTooSmall, place + reason);
      return result;
    }
  }
  return result;
}

}  // namespace feder
