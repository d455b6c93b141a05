#pragma once

#include <functional>
#include <vector>

#include "engine/status.h"
#include "solvers/joint_step.h"

namespace feder {

/// How joints answer to the next piece of a path.
enum class PathMethod {
  kPseudoInverse,  ///< J^+: exact, stops where the path meets a singular pose it cannot pass
  kDamped,         ///< gamma near singular poses, and a limit of speed, for an error of the path: it goes on
                   ///< to the end however far off, even from a pose that cannot move towards the path
  kNullSpace       ///< J^+ and, with the joints to spare, towards larger manipulability
};

struct PathOptions {
  PathMethod method = PathMethod::kPseudoInverse;
  int pieces = 200;            ///< of the path, at least; halved where needed
  double duration = 1.0;       ///< [s]
  double tolerance = 1e-10;    ///< of place [m] and angle [rad] at the end of a piece
  double length = 1.0;         ///< metres a radian weighs
  double most_turn = 0.2;      ///< of a joint in one piece [rad], [m]
  double least_piece = 1e-10;  ///< of the path: below, the run ends with kStepTooSmall
  Damping damping = {};        ///< kDamped ...
  double most_speed = 10.0;    ///< ... which cuts its steps to this, of the fastest joint [rad/s, m/s]
  double null_rate = 2.0;      ///< kNullSpace: z = rate grad log manipulability, [1/s] ...
  double null_speed = 2.0;     ///< ... cut to this length [rad/s]
};

struct PathPoint {
  double s = 0.0;  ///< in [0, 1]
  VectorXd q;
  PoseError error;
  double speed = 0.0;     ///< |dq| / dt since the point before [rad/s, m/s]
  double smallest = 0.0;  ///< singular value of A
};

struct PathResult {
  Status status;
  std::vector<PathPoint> points;  ///< up to where the run ended
  int halvings = 0;
};

/// Joints along a path of poses, s from 0 to 1, from `start`, which must be on it (InputError otherwise; also
/// for a tolerance that rounding cannot keep). kNonFinite or kInconsistent where the path gives no pose.
/// Within the limits throughout, and continuous: no joint moves by more than `most_turn` between points.
/// kPseudoInverse and kNullSpace take a piece only if A changes by less than its smallest singular value: by
/// Weyl's inequality no singular pose, where alone branches meet, lies between.
PathResult follow_path(const KinematicMap& map, const std::function<Pose(double s)>& path,
                       const VectorXd& start, const PathOptions& options = {});

}  // namespace feder
