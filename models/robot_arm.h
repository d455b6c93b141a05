#pragma once

#include "models/model.h"
#include "models/robot/control.h"

namespace feder {

enum class ArmControl {
  kLoose,          ///< falls
  kMotors,         ///< joints on their path exactly: rigid rows with the path as target
  kPd,             ///< the same rows as spring and damper, which is PD control: gives way under the load
  kComputedTorque  ///< torques of the path's inverse dynamics, and PD on what is left
};

/// An arm of the catalogue of arms as bodies, led from one pose to another.
struct RobotArm {
  int arm = 2;  ///< place in arm_list(): puma560
  ArmControl control = ArmControl::kPd;
  double sweep = 0.3;       ///< way of each joint, of its limits (at most half a turn), in turn to and fro
  double duration = 1.0;    ///< of the motion [s]
  double frequency = 40.0;  ///< of the controls, critically damped [rad/s]
  double gravity = 9.81;    ///< along -z [m/s^2]
};

/// Around the middle of the limits.
JointPath path_of(const RobotArm& options);
Model make_robot_arm(const RobotArm& options = {});
ModelInfo robot_arm_model();

}  // namespace feder
