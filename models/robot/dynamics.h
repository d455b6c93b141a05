#pragma once

#include <vector>

#include "engine/mass_properties.h"
#include "models/robot/dh.h"

namespace feder {

/// How a link moves, in world axes.
struct LinkMotion {
  Pose frame;                       ///< of the table
  Vector3d axis, joint;             ///< its joint's axis z and a point on it [m]
  Vector3d turning, turning_rate;   ///< angular velocity and its rate [rad/s, rad/s^2]
  Vector3d velocity, acceleration;  ///< of the frame's origin [m/s, m/s^2]

  Vector3d velocity_at(const Vector3d& place) const;
  Vector3d acceleration_at(const Vector3d& place) const;
};

/// From joint values, speeds and accelerations, one per joint; the base rests at the identity.
std::vector<LinkMotion> link_motions(const Arm& arm, const VectorXd& q, const VectorXd& speeds,
                                     const VectorXd& accelerations);

/// Joint values from the frames of the links, each nearest to `near` (whole turns are not seen).
VectorXd joint_values(const Arm& arm, const std::vector<Pose>& links, const VectorXd& near);

/// Torques [N m] or forces [N] of the joints that give these accelerations (recursive Newton-Euler; Luh,
/// Walker and Paul 1980). Links in the axes of their frames; gravity [m/s^2] in world axes.
VectorXd inverse_dynamics(const Arm& arm, const std::vector<MassProperties>& links, const Vector3d& gravity,
                          const VectorXd& q, const VectorXd& speeds, const VectorXd& accelerations);

/// Diagonal of the joint-space mass matrix at q: what each joint feels of the links behind it [kg m^2] or
/// [kg].
VectorXd joint_inertias(const Arm& arm, const std::vector<MassProperties>& links, const VectorXd& q);

}  // namespace feder
