#pragma once

#include <vector>

#include "engine/system.h"
#include "models/robot/dynamics.h"

namespace feder {

/// The bodies of an arm in a system: one per link on hinges and prismatic joints, the first on the world.
struct ArmBodies {
  std::vector<Anchor> links;      ///< at the origins of the frames of the table
  std::vector<LinkMotion> start;  ///< where the joints' axes lie at the start
};
/// At joints q with these speeds; links as link_bodies gives them.
ArmBodies add_arm(SystemBuilder& builder, const Arm& arm, const std::vector<MassProperties>& links,
                  const VectorXd& q, const VectorXd& speeds);
/// Frames of the links as the bodies stand.
std::vector<Pose> link_frames(const System& system, const ArmBodies& bodies, const VectorXd& q);

}  // namespace feder
