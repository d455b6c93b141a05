// Leads the joints of an arm's bodies along a path: rows with a target, or torques.
#pragma once

#include <vector>

#include "models/robot/bodies.h"

namespace feder {

/// From rest at `start` to rest at `goal` in `duration` [s], along 10 s^3 - 15 s^4 + 6 s^5.
struct JointPath {
  VectorXd start, goal;
  double duration = 1.0;
  VectorXd value(double t) const, rate(double t) const, acceleration(double t) const;
};

/// A row along the freedom of every joint, with the path as its target: a motor where its material is rigid,
/// a PD control where it is a spring with damping. The bodies must stand at the path's start.
void add_drives(SystemBuilder& builder, const Arm& arm, const ArmBodies& bodies, const JointPath& path,
                const std::vector<Material>& materials);

/// PD controls of this frequency [rad/s], critically damped by what each joint feels at q.
std::vector<Material> pd_materials(const Arm& arm, const std::vector<MassProperties>& links,
                                   const VectorXd& q, double frequency);

/// Torques by inverse dynamics that follow the path, errors dying out as (1 + w t) exp(-w t). `bodies` of the
/// built system, the arm's and in its order.
UserForce computed_torque(const Arm& arm, const std::vector<MassProperties>& links,
                          const std::vector<Body>& bodies, const JointPath& path, const Vector3d& gravity,
                          double frequency);

}  // namespace feder
