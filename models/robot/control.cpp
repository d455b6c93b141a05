// PD control of joint i is a row with phi = q - q_d, d = w^2 I_i, b = 2 w I_i, I_i the inertia that the joint
// feels at the start; computed torque is
//   torque = inverse dynamics of (q, q', q_d'' + 2 w (q_d' - q') + w^2 (q_d - q)).
#include "models/robot/control.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

#include "engine/check.h"
#include "engine/joints.h"

namespace feder {
namespace {

Target joint_target(const JointPath& path, int i) {
  return {[=](double t) { return path.value(t)[i] - path.start[i]; },
          [=](double t) { return path.rate(t)[i]; }, [=](double t) { return path.acceleration(t)[i]; }};
}

// Torques between neighbours as a user force.
struct Controller {
  Arm arm;
  std::vector<MassProperties> links;
  std::vector<Body> bodies;
  JointPath path;
  Vector3d gravity;
  double frequency;

  Pose frame(int i, const VectorXd& q) const {
    const Body& b = bodies[i];
    const Matrix3d axes = orientation(b, q);
    return {axes, q.segment<3>(3 * b.centre) - axes * b.centre_point};
  }
  // Force [N] and torque [N m] in world axes on a body, at a place.
  void push(int i, const VectorXd& q, const Vector3d& place, const Vector3d& force, const Vector3d& torque,
            VectorXd& f) const {
    const Body& b = bodies[i];
    const Vector3d moment = torque + (place - q.segment<3>(3 * b.centre)).cross(force);
    f.segment<3>(3 * b.centre) += force;
    f.segment<3>(3 * b.spin) += rotation_matrix(q.data() + b.quaternion).transpose() * moment;
  }
  void operator()(double t, const VectorXd& q, const VectorXd& v, VectorXd& f) const;
};

void Controller::operator()(double t, const VectorXd& q, const VectorXd& v, VectorXd& f) const {
  const int n = arm.joints();
  // where the joints are, and how fast
  std::vector<Pose> poses;
  poses.reserve(bodies.size());
  for (int i = 0; i < n; ++i) poses.push_back(frame(i, q));
  const VectorXd wanted = path.value(t), joints = joint_values(arm, poses, wanted), rest = VectorXd::Zero(n);
  const std::vector<LinkMotion> at = link_motions(arm, joints, rest, rest);
  VectorXd speeds(n);
  Vector3d turning = Vector3d::Zero(), velocity = Vector3d::Zero(), place = Vector3d::Zero();
  for (int i = 0; i < n; ++i) {
    const Body& b = bodies[i];
    const Vector3d w = rotation_matrix(q.data() + b.quaternion) * v.segment<3>(3 * b.spin);
    const Vector3d c = q.segment<3>(3 * b.centre), to = v.segment<3>(3 * b.centre);
    const Vector3d along = to - velocity - turning.cross(c - place);  // of c against the link before
    speeds[i] = at[i].axis.dot(arm.rows[i].prismatic ? along : Vector3d(w - turning));
    turning = w, velocity = to, place = c;
  }
  // torques, and their opposites on the link before
  const VectorXd pull = path.acceleration(t) + 2.0 * frequency * (path.rate(t) - speeds) +
                        frequency * frequency * (wanted - joints);
  const VectorXd torques = inverse_dynamics(arm, links, gravity, joints, speeds, pull);
  for (int i = 0; i < n; ++i) {
    const Vector3d along = torques[i] * at[i].axis, none = Vector3d::Zero();
    const Vector3d force = arm.rows[i].prismatic ? along : none,
                   torque = arm.rows[i].prismatic ? none : along;
    push(i, q, at[i].joint, force, torque, f);
    if (i > 0) push(i - 1, q, at[i].joint, -force, -torque, f);
  }
}

}  // namespace

VectorXd JointPath::value(double t) const {
  const double s = std::clamp(t / duration, 0.0, 1.0);
  return start + s * s * s * (10.0 - s * (15.0 - 6.0 * s)) * (goal - start);
}
VectorXd JointPath::rate(double t) const {
  const double s = std::clamp(t / duration, 0.0, 1.0);
  return 30.0 * s * s * (1.0 - s) * (1.0 - s) / duration * (goal - start);
}
VectorXd JointPath::acceleration(double t) const {
  const double s = std::clamp(t / duration, 0.0, 1.0);
  return 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (duration * duration) * (goal - start);
}

void add_drives(SystemBuilder& builder, const Arm& arm, const ArmBodies& bodies, const JointPath& path,
                const std::vector<Material>& materials) {
  for (int i = 0; i < arm.joints(); ++i) {
    const Anchor before = i > 0 ? bodies.links[i - 1] : Anchor{};
    const LinkMotion& at = bodies.start[i];
    if (arm.rows[i].prismatic)
      add_slide(builder, before, bodies.links[i], at.joint, at.axis, materials[i], joint_target(path, i));
    else
      add_turn(builder, before, bodies.links[i], at.axis, materials[i], joint_target(path, i));
  }
}

std::vector<Material> pd_materials(const Arm& arm, const std::vector<MassProperties>& links,
                                   const VectorXd& q, double frequency) {
  std::vector<Material> materials;
  for (const double inertia : joint_inertias(arm, links, q))
    materials.push_back({.stiffness = frequency * frequency * inertia, .damping = 2.0 * frequency * inertia});
  return materials;
}

UserForce computed_torque(const Arm& arm, const std::vector<MassProperties>& links,
                          const std::vector<Body>& bodies, const JointPath& path, const Vector3d& gravity,
                          double frequency) {
  FEDER_CHECK(std::ssize(bodies) == arm.joints(), "the bodies of the arm alone");
  UserForce force;
  force.force = Controller{arm, links, bodies, path, gravity, frequency};
  return force;
}

}  // namespace feder
