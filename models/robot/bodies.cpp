// Joint i turns or slides between the bodies of links i - 1 and i, about the z axis of its row of the table.
#include "models/robot/bodies.h"

#include "engine/joints.h"

namespace feder {

ArmBodies add_arm(SystemBuilder& builder, const Arm& arm, const std::vector<MassProperties>& links,
                  const VectorXd& q, const VectorXd& speeds) {
  ArmBodies bodies;
  bodies.start = link_motions(arm, q, speeds, VectorXd::Zero(arm.joints()));
  Anchor before;
  for (int i = 0; i < arm.joints(); ++i) {
    const LinkMotion& m = bodies.start[i];
    const Vector3d centre = m.frame.position + m.frame.rotation * links[i].centre;
    const Anchor link = builder.add_body(links[i], {.position = m.frame.position,
                                                    .orientation = m.frame.rotation,
                                                    .velocity = m.velocity_at(centre),
                                                    .angular_velocity = m.turning});
    (arm.rows[i].prismatic ? add_prismatic : add_hinge)(builder, before, link, m.joint, m.axis, {});
    bodies.links.push_back(link);
    before = link;
  }
  return bodies;
}

std::vector<Pose> link_frames(const System& system, const ArmBodies& bodies, const VectorXd& q) {
  std::vector<Pose> poses;
  for (const Anchor& link : bodies.links)
    poses.push_back({orientation(system.bodies[link.body], q), position(system, link, q)});
  return poses;
}

}  // namespace feder
