#pragma once

#include <cstdint>

#include "engine/status.h"
#include "solvers/joint_step.h"

namespace feder {

enum class PoseOutcome {
  kReached,      ///< within the tolerance
  kUnreachable,  ///< the pose returned is the closest found, a local minimum of the error within the limits
  kNotConverged  ///< the budget ended on the way
};
const char* to_string(PoseOutcome outcome);

struct InverseKinematicsOptions {
  double tolerance = 1e-11;   ///< of place [m] and angle [rad], at least 16 epsilon of the reach
  double length = 0.0;        ///< metres that a radian of error weighs; 0: a third of the reach
  int most_starts = 200;      ///< the given joints, then places spread evenly within the limits
  int most_iterations = 100;  ///< per start
  std::uint64_t seed = 0;     ///< shifts the spread of starts
};

struct InverseKinematicsResult {
  PoseOutcome outcome = PoseOutcome::kNotConverged;
  bool proved = false;  ///< unreachable by the reach of the links, whatever the joints
  VectorXd q;           ///< within the limits
  PoseError error;
  int starts = 0, iterations = 0;  ///< used, over all starts

  /// kOk only if reached; otherwise the reason with what is left of the error.
  Status status() const;
};

/// Joints for a pose of the tool: Gauss-Newton steps through J^+ with damping gamma, from one start after
/// the other.
class InverseKinematics {
 public:
  /// Keeps a copy of the map. InputError for options out of range.
  explicit InverseKinematics(const KinematicMap& map, const InverseKinematicsOptions& options = {});
  InverseKinematics(const InverseKinematics&) = delete;
  InverseKinematics& operator=(const InverseKinematics&) = delete;

  /// InputError for a target that is not finite or whose rotation is none, or for a start outside the limits.
  InverseKinematicsResult solve(const Pose& target, const VectorXd& start);
  /// From the middle of the limits.
  InverseKinematicsResult solve(const Pose& target);

  const KinematicMap& map() const { return map_; }

 private:
  enum class End { kReached, kMinimum, kBudget };
  // Where a start was given up, and |e| there [m].
  struct Near {
    double left;
    VectorXd q;
  };
  End descend(const Pose& target, VectorXd& q, int most_iterations, bool patient);
  void descend_from_near(const Pose& target, const std::function<bool(End, const VectorXd&)>& done);
  void spread(int start, VectorXd& q) const;
  bool within_reach(const Pose& target) const;

  KinematicMap map_;
  InverseKinematicsOptions options_;
  JointStep here_, there_;
  VectorXd ratios_, zero_, x_, trial_;
  std::vector<Near> near_;
  int iterations_ = 0;
};

}  // namespace feder
