// Levenberg-Marquardt on |e|^2: x = A^T y, (A A^T + gamma) y = e, gamma = mu |e|^2 (T. Sugihara, IEEE Trans.
// Robotics 27, 2011: with the error itself as damping steps stay bounded at singular poses and converge
// quadratically where the error goes to 0). mu falls after a step that helped and grows after one that did
// not. Starts: q_k = least + frac(shift_k + i phi^-k) (greatest - least), phi^(n+1) = phi + 1 (the additive
// recurrence of the generalised golden ratio).
#include "solvers/inverse_kinematics.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>

#include "engine/check.h"

namespace feder {
namespace {

constexpr double kFirst = 1e-2, kFall = 0.2, kGrow = 6.0;  // of mu
constexpr double kFloor = 1e-15;     // of gamma, of the largest S: keeps it positive definite to rounding
constexpr double kSlow = 0.02;       // a step gains less than this part of |e|^2 ...
constexpr int kPatience = 4;         // ... so often in a row: a local minimum, the next start is cheaper
constexpr double kFarthest = 1e100;  // of a target [m]: its square is a number
constexpr double kRounding = 1e-15;  // of |e|^2
constexpr double kDownhill = 1e-12;  // of |A|^2 |e|^2: below, |A^T e|^2 is none
constexpr double kNear = 0.05;       // of the length: so near to a target no start is given up unseen
constexpr int kFirstLook = 8;        // starts before the first patient descent
constexpr int kProvedStarts = 20, kPatientIterations = 20000, kNearIterations = 1000;
constexpr auto kWrap = JointStep::AtLimits::kWrap;

double checked_length(const KinematicMap& map, const InverseKinematicsOptions& o) {
  const std::string place = "inverse kinematics of '" + map.name + "'";
  require_tolerance(place, o.tolerance, map);
  require_non_negative(place, "length", o.length, "m");
  if (o.most_starts < 1) fail_input(place, "most_starts", o.most_starts, "", "at least 1");
  if (o.most_iterations < 1) fail_input(place, "most_iterations", o.most_iterations, "", "at least 1");
  if (o.length > 0.0) return o.length;
  return map.reach.greatest > 0.0 ? map.reach.greatest / 3.0 : 1.0;
}

void check_target(const KinematicMap& map, const Pose& target, const VectorXd& start) {
  const std::string place = "inverse kinematics of '" + map.name + "'";
  for (int k = 0; k < 3; ++k) require_finite(place, "target position", target.position[k], "m");
  if (!(target.position.norm() < kFarthest))
    fail_input(place, "distance of the target", target.position.stableNorm(), "m", "less than 1e100");
  const double off = off_rotation(target.rotation);
  if (!(off < kRotation))
    fail_input(place, "|R R^T - E| of the target", off, "", "less than 1e-9: a rotation, no reflection");
  FEDER_CHECK(start.size() == map.joints(), "as many joint values as the arm has joints");
  for (int i = 0; i < start.size(); ++i)
    if (!(start[i] >= map.least[i] && start[i] <= map.greatest[i]))
      fail_input(place, "start of joint " + std::to_string(i + 1), start[i], "rad or m", "within its limits");
}

}  // namespace

const char* to_string(PoseOutcome outcome) {
  switch (outcome) {
    case PoseOutcome::kReached:
      return "reached";
    case PoseOutcome::kUnreachable:
      return "unreachable";
    case PoseOutcome::kNotConverged:
      return "not_converged";
  }
  return "";
}

Status InverseKinematicsResult::status() const {
  if (outcome == PoseOutcome::kReached) return {};
  char left[96];
  std::snprintf(left, sizeof left, "closest pose found is %.3g m and %.3g rad away", error.place,
                error.angle);
  if (outcome == PoseOutcome::kNotConverged) return Status::failure(StatusCode::kNotConverged, left);
  return Status::failure(
      StatusCode::kInconsistent,
      std::string(proved ? "target out of reach of the links: " : "target not reached: ") + left);
}

InverseKinematics::InverseKinematics(const KinematicMap& map, const InverseKinematicsOptions& options)
    : map_(map),
      options_(options),
      here_(map_, checked_length(map_, options)),
      there_(map_, checked_length(map_, options)),
      ratios_(map.joints()),
      zero_(VectorXd::Zero(map.joints())) {
  double phi = 1.5;
  for (int i = 0; i < 60; ++i) phi = std::pow(1.0 + phi, 1.0 / (map.joints() + 1));
  for (int k = 0; k < map.joints(); ++k) ratios_[k] = std::pow(phi, -(k + 1));
}

void InverseKinematics::spread(int start, VectorXd& q) const {
  for (int k = 0; k < q.size(); ++k) {
    const double part =
        0.5 + std::fmod(ratios_[k] * (start + static_cast<double>(options_.seed % 1000003)), 1.0);
    q[k] = map_.least[k] + (part - std::floor(part)) * (map_.greatest[k] - map_.least[k]);
  }
}

bool InverseKinematics::within_reach(const Pose& target) const {
  double squared = 0.0;
  for (const int row : map_.task)
    if (row < 3) squared += std::pow(target.position[row] - map_.reach.centre[row], 2);
  const double distance = std::sqrt(squared), slack = options_.tolerance + 1e-14 * map_.reach.greatest;
  return distance <= map_.reach.greatest + slack && distance >= map_.reach.least - slack;
}

InverseKinematics::End InverseKinematics::descend(const Pose& target, VectorXd& q, int most_iterations,
                                                  bool patient) {
  double mu = kFirst;
  int slow = 0;
  here_.linearise(q, target);
  for (int i = 0; i < most_iterations; ++i) {
    const PoseError error = here_.pose_error();
    if (error.place <= options_.tolerance && error.angle <= options_.tolerance) return End::kReached;
    const double squared = here_.error().squaredNorm(), size = here_.matrix().squaredNorm();
    // the step, and where it leads
    ++iterations_;
    const double gamma = mu * squared + kFloor * size;
    if (!here_.step(q, zero_, gamma, x_, kWrap)) {
      mu *= kGrow;
      continue;
    }
    // a minimum within the limits: no step is left that rounding could see
    if (std::abs(x_.dot(here_.matrix().transpose() * here_.error())) <= kRounding * squared) {
      // nor is it only that joints are held which the gradient would bring in: more damping frees them
      if (gamma > size / kDownhill || here_.free_gradient(q, kWrap) <= kDownhill * size * squared)
        return End::kMinimum;
      mu *= kGrow;
      continue;
    }
    trial_ = q;
    here_.take(x_, trial_, kWrap);
    there_.linearise(trial_, target);
    const double gain = 1.0 - there_.error().squaredNorm() / squared;
    slow = gain > kSlow ? 0 : slow + 1;
    if (!patient && slow >= kPatience) return End::kMinimum;
    if (gain > 0.0) {
      q.swap(trial_);
      std::swap(here_, there_);
      mu *= kFall;
    } else {
      mu *= kGrow;
    }
  }
  return End::kBudget;
}

InverseKinematicsResult InverseKinematics::solve(const Pose& target) {
  return solve(target, 0.5 * (map_.least + map_.greatest));
}

InverseKinematicsResult InverseKinematics::solve(const Pose& target, const VectorXd& start) {
  check_target(map_, target, start);
  InverseKinematicsResult best;
  best.proved = !within_reach(target);
  const int most_starts = best.proved ? std::min(kProvedStarts, options_.most_starts) : options_.most_starts;
  double least = std::numeric_limits<double>::infinity();
  End bottom = End::kBudget;
  VectorXd q = best.q = start;
  iterations_ = 0;
  near_.clear();
  // true where q is better than all before it
  auto take = [&](End end, const VectorXd& at) {
    if (end != End::kReached && !(here_.error().squaredNorm() < least)) return false;
    least = here_.error().squaredNorm(), best.q = at, best.error = here_.pose_error();
    if (end == End::kReached) best.outcome = PoseOutcome::kReached;
    return true;
  };
  bool deeper = false;
  for (best.starts = 1;; ++best.starts) {
    deeper = take(descend(target, q, options_.most_iterations, false), q) || deeper;
    const double left = here_.error().norm();
    if (left < kNear * here_.length()) near_.push_back({left, q});
    const bool last = best.starts == most_starts,
               look = std::has_single_bit(static_cast<unsigned>(best.starts));
    if (last && !best.proved)
      descend_from_near(target, [&](End end, const VectorXd& at) {
        deeper = take(end, at) || deeper;
        return best.outcome == PoseOutcome::kReached;
      });
    // now and then from the best of all starts to the bottom of its valley: some are long
    if (best.outcome != PoseOutcome::kReached && deeper && (last || (look && best.starts >= kFirstLook))) {
      q = best.q;
      bottom = descend(target, q, kPatientIterations, true);
      take(bottom, q);
      deeper = false;
    }
    if (last || best.outcome == PoseOutcome::kReached) break;
    spread(best.starts, q);
  }
  if (best.outcome != PoseOutcome::kReached && bottom == End::kMinimum)
    best.outcome = PoseOutcome::kUnreachable;
  best.proved = best.proved && best.outcome == PoseOutcome::kUnreachable;
  best.iterations = iterations_;
  return best;
}

// At the edge of the reach valleys are narrow and long, and the best start need not lie in one that leads to
// the target: before it is given up all that came near follow theirs, nearest first.
void InverseKinematics::descend_from_near(const Pose& target,
                                          const std::function<bool(End, const VectorXd&)>& done) {
  std::sort(near_.begin(), near_.end(), [](const Near& a, const Near& b) { return a.left < b.left; });
  for (Near& near : near_) {
    const End end = descend(target, near.q, kNearIterations, true);
    if (done(end, near.q)) return;
  }
}

}  // namespace feder
