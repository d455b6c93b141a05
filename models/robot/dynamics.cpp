// Outwards, link by link (w angular velocity, z joint axis; a link's points move as a rigid field):
//   revolute   w_i = w_(i-1) + z q',   w_i' = w_(i-1)' + z q'' + w_(i-1) x z q'
//   prismatic  the field of i - 1 plus z q', its acceleration plus z q'' + 2 w x z q'
// Inwards, about the world's origin:
//   F = m (a_c - g),  N = I w' + w x I w,  torque_j = z_j . sum_(i >= j) (N_i + (c_i - o_j) x F_i)
#include "models/robot/dynamics.h"

#include <Eigen/Geometry>
#include <cmath>

#include "engine/check.h"

namespace feder {

Vector3d LinkMotion::velocity_at(const Vector3d& place) const {
  return velocity + turning.cross(place - frame.position);
}

Vector3d LinkMotion::acceleration_at(const Vector3d& place) const {
  const Vector3d r = place - frame.position;
  return acceleration + turning_rate.cross(r) + turning.cross(turning.cross(r));
}

std::vector<LinkMotion> link_motions(const Arm& arm, const VectorXd& q, const VectorXd& speeds,
                                     const VectorXd& accelerations) {
  const int n = arm.joints();
  FEDER_CHECK(speeds.size() == n && accelerations.size() == n, "a speed and an acceleration per joint");
  const std::vector<Pose> poses = frames(arm, q);
  LinkMotion last{Pose{},           Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero(),
                  Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()};
  std::vector<LinkMotion> motions;
  for (int i = 0; i < n; ++i) {
    LinkMotion m = last;
    m.frame = poses[i + 1];
    // the joint's axis is fixed in the frame before (standard) or in its own (modified)
    const Pose& on_axis = arm.convention == DhConvention::kStandard ? poses[i] : poses[i + 1];
    m.axis = on_axis.rotation.col(2);
    m.joint = on_axis.position;
    const Vector3d rate = speeds[i] * m.axis, more = accelerations[i] * m.axis;
    // the field at the frame's new origin, first as if the joint stood still
    m.velocity = last.velocity_at(m.frame.position);
    m.acceleration = last.acceleration_at(m.frame.position);
    if (arm.rows[i].prismatic) {
      m.velocity += rate;
      m.acceleration += more + 2.0 * last.turning.cross(rate);
    } else {
      const Vector3d r = m.frame.position - m.joint;
      m.turning += rate;
      m.turning_rate += more + last.turning.cross(rate);
      m.velocity += rate.cross(r);
      m.acceleration += (more + last.turning.cross(rate)).cross(r) + m.turning.cross(m.turning.cross(r)) -
                        last.turning.cross(last.turning.cross(r));
    }
    motions.push_back(m);
    last = m;
  }
  return motions;
}

VectorXd joint_values(const Arm& arm, const std::vector<Pose>& links, const VectorXd& near) {
  VectorXd q(arm.joints());
  Pose before;
  for (int i = 0; i < arm.joints(); ++i) {
    const DhRow& row = arm.rows[i];
    // what the row's own motion about z is: the rest of the row undone
    DhRow rest = row;
    rest.d = rest.theta = 0.0;
    rest.prismatic = false;
    const Pose link = product(inverse(before), links[i]), still = row_transform(rest, arm.convention, 0.0);
    const Pose moved = arm.convention == DhConvention::kStandard ? product(link, inverse(still))
                                                                 : product(inverse(still), link);
    if (row.prismatic) {
      q[i] = moved.position.z() - row.d;
    } else {
      const double angle = std::atan2(moved.rotation(1, 0), moved.rotation(0, 0)) - row.theta;
      q[i] = near[i] + std::remainder(angle - near[i], 2.0 * std::numbers::pi);
    }
    before = links[i];
  }
  return q;
}

VectorXd inverse_dynamics(const Arm& arm, const std::vector<MassProperties>& links, const Vector3d& gravity,
                          const VectorXd& q, const VectorXd& speeds, const VectorXd& accelerations) {
  FEDER_CHECK(std::ssize(links) == arm.joints(), "a body per link");
  const std::vector<LinkMotion> motions = link_motions(arm, q, speeds, accelerations);
  VectorXd torques(arm.joints());
  Vector3d force = Vector3d::Zero(), moment = Vector3d::Zero();
  for (int i = arm.joints() - 1; i >= 0; --i) {
    const LinkMotion& m = motions[i];
    const Vector3d centre = m.frame.position + m.frame.rotation * links[i].centre;
    const Matrix3d I = m.frame.rotation * links[i].inertia * m.frame.rotation.transpose();
    const Vector3d F = links[i].mass * (m.acceleration_at(centre) - gravity);
    force += F;
    moment += I * m.turning_rate + m.turning.cross(I * m.turning) + centre.cross(F);
    torques[i] = arm.rows[i].prismatic ? m.axis.dot(force) : m.axis.dot(moment - m.joint.cross(force));
  }
  return torques;
}

VectorXd joint_inertias(const Arm& arm, const std::vector<MassProperties>& links, const VectorXd& q) {
  const VectorXd rest = VectorXd::Zero(arm.joints());
  VectorXd diagonal(arm.joints());
  for (int i = 0; i < arm.joints(); ++i)
    diagonal[i] = inverse_dynamics(arm, links, Vector3d::Zero(), q, rest, VectorXd::Unit(arm.joints(), i))[i];
  return diagonal;
}

}  // namespace feder
