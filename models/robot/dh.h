// Arms as tables of Denavit and Hartenberg (notes F7 to F9): forward kinematics, Jacobian, reach.
#pragma once

#include <numbers>
#include <string>
#include <vector>

#include "engine/kinematic_map.h"

namespace feder {

/// Order of the four motions of a row. Standard: Rot(z, theta) Trans(z, d) Trans(x, a) Rot(x, alpha), joint i
/// about the z axis of the frame before. Modified (Craig): Rot(x, alpha) Trans(x, a) Rot(z, theta) Trans(z,
/// d), joint i about its own z axis. The same numbers mean different arms.
enum class DhConvention { kStandard, kModified };

/// One joint and its link. The joint value q is added to theta (revolute) or to d (prismatic).
struct DhRow {
  double a = 0.0;      ///< link length, along x [m]
  double alpha = 0.0;  ///< twist, the angle about x between the z axes [rad]
  double d = 0.0;      ///< offset, along z [m]
  double theta = 0.0;  ///< angle about z between the x axes [rad]
  bool prismatic = false;
  double least = -std::numbers::pi, greatest = std::numbers::pi;  ///< limits of q [rad] or [m]
};

struct Arm {
  std::string name;
  DhConvention convention = DhConvention::kStandard;
  std::vector<DhRow> rows;
  Pose tool = {};                              ///< in the last frame
  std::vector<int> task = {0, 1, 2, 3, 4, 5};  ///< see KinematicMap

  int joints() const { return static_cast<int>(rows.size()); }
};

/// InputError naming the row unless there is a joint, all is finite, least < greatest, the tool a pose and
/// the task made of rows 0 to 5 in ascending order.
void check_arm(const Arm& arm);

/// first * second: a point of the inner frame in the outer one, or the first frame moved on (notes F8).
Pose product(const Pose& first, const Pose& second);
Pose inverse(const Pose& pose);
/// [R t; 0 1].
Eigen::Matrix4d homogeneous(const Pose& pose);

/// (i-1)T(i) of one row (notes F9).
Pose row_transform(const DhRow& row, DhConvention convention, double q);

/// Poses 0T0 = identity, 0T1, ... 0Tn and, last, of the tool: n + 2. q has n entries.
std::vector<Pose> frames(const Arm& arm, const VectorXd& q);
Pose tool_pose(const Arm& arm, const VectorXd& q);
/// J, 6 x n.
ToolJacobian tool_jacobian(const Arm& arm, const VectorXd& q);

/// The same arm by a modified table: a and alpha move to the next row, the last ones into the tool.
Arm as_modified(const Arm& arm);

/// From the lengths l_i between joint axes (notes F5 for more than two links): the tool's distance from the
/// place of the first joint is at most sum l_i, and at least the longest link less all others. Distances over
/// the place rows of the task, which leave a least one only if they are all three or all axes are parallel to
/// z and they are x and y.
Ring reach_of(const Arm& arm);

/// Checks the table first.
KinematicMap kinematic_map(const Arm& arm);

}  // namespace feder
