#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "engine/geometry/shape.h"

namespace feder {

/// Places at a distance from `least` to `greatest` from the centre [m].
struct Ring {
  Vector3d centre = Vector3d::Zero();
  double least = 0.0, greatest = 0.0;
};

/// One column per joint: velocity of the tool's origin (rows 0 to 2, [m/s]) and angular velocity (3 to 5,
/// [rad/s]) in world axes at joint speed 1: the geometric Jacobian J, 6 x n.
using ToolJacobian = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// What inverse kinematics has to know of an arm: pose and Jacobian of its tool as functions of the joints.
/// models/robot makes one from a table, solvers/inverse_kinematics.h uses it; neither knows the other.
/// `evaluate` may keep numbers between calls: a copy for every thread.
struct KinematicMap {
  std::string name;
  VectorXd least, greatest;  ///< limits of the joints q [rad] or [m], finite, least < greatest
  std::vector<char> turns;   ///< not 0: a whole turn further it is the same pose (revolute joints)
  std::vector<int> task;  ///< rows of J that count, ascending: a planar arm commands {0, 1}, others all six
  Ring reach;             ///< contains every place of the tool, distances over the task's place rows alone
  std::function<void(const double* q, Pose& tool, ToolJacobian& jacobian)> evaluate;

  int joints() const { return static_cast<int>(least.size()); }
};

}  // namespace feder
