#pragma once

#include <vector>

#include "engine/kinematic_map.h"
#include "solvers/pseudo_inverse.h"

namespace feder {

/// The rotation vector of a rotation [rad], of length <= pi.
Vector3d rotation_vector(const Matrix3d& rotation);
/// |R R^T - E|, infinite for a reflection; a rotation if less than kRotation.
double off_rotation(const Matrix3d& R);
inline constexpr double kRotation = 1e-9;
/// InputError unless a tolerance [m and rad] is positive and no less than what rounding leaves, 16 epsilon of
/// the reach.
void require_tolerance(const std::string& place, double tolerance, const KinematicMap& map);

/// What is left between tool and target.
struct PoseError {
  double place = 0.0;  ///< [m]
  double angle = 0.0;  ///< [rad]
};

/// One linearisation of an arm at joints q towards a target: A q' = e over the rows of its task, turns
/// weighed by `length` [m] so that both are metres; and the steps it proposes, within the joint limits.
class JointStep {
 public:
  /// What full-turn joints do at a limit: stop, or come in again from the other side (the same pose).
  enum class AtLimits { kStop, kWrap };

  /// The map must outlive it. length > 0 [m].
  JointStep(const KinematicMap& map, double length);

  /// A and e at q.
  void linearise(const VectorXd& q, const Pose& target);
  const Eigen::MatrixXd& matrix() const { return A_; }  ///< [m] or 1
  const VectorXd& error() const { return e_; }          ///< [m]
  PoseError pose_error() const;
  double length() const { return length_; }
  const Pose& tool() const { return tool_; }
  /// |A^T e|^2 over the joints that may turn downhill: not those at a limit that e draws outwards.
  double free_gradient(const VectorXd& q, AtLimits at = AtLimits::kStop) const;

  /// The step of
  ///     x = z + A^T y,   A x + gamma y = e,   q + x within the limits:
  /// e is approached by the least change of what z would do alone; z moves in the null space of A where A x =
  /// e can be kept. Joints that would leave their limits are held there, worst first, and the others solved
  /// again. False if S = A A^T + gamma of the free joints is singular.
  bool step(const VectorXd& q, const VectorXd& z, double gamma, VectorXd& x, AtLimits at = AtLimits::kStop);
  /// q <- q + x, exactly within the limits.
  void take(const VectorXd& x, VectorXd& q, AtLimits at = AtLimits::kStop) const;
  int solves() const { return solves_; }  ///< of the last step: 1 + joints held

 private:
  bool wraps(int joint) const;
  bool solve_free(const VectorXd& z, double gamma, VectorXd& x);

  const KinematicMap* map_;
  double length_;
  Pose tool_;
  ToolJacobian J_;
  Eigen::MatrixXd A_;
  VectorXd e_;
  std::vector<char> held_;
  SmallDual S_;
  int solves_ = 0;
};

}  // namespace feder
