#pragma once

#include "engine/state.h"

namespace feder {

/// One side of a contact, all in world axes. A stationary partner has inverse mass and inertia 0 (notes D4);
/// a particle has no inverse inertia.
struct ContactBody {
  double inverse_mass = 0.0;                    ///< [1/kg], >= 0
  Matrix3d inverse_inertia = Matrix3d::Zero();  ///< about the centre [1/(kg m^2)], symmetric, semidefinite
  Vector3d arm = Vector3d::Zero();              ///< from the centre to the point of contact [m]
};

/// Velocity of the centre [m/s] and angular velocity in world axes [rad/s].
struct BodyVelocity {
  Vector3d linear = Vector3d::Zero();
  Vector3d angular = Vector3d::Zero();
};

/// Columns normal, first and second tangent: a rotation that depends on the normal alone. Misuse: a normal
/// that is no unit vector (to 1e-9).
Matrix3d contact_axes(const Vector3d& normal);

/// W = J M^-1 J^T of a against b along the columns of `axes` [1/kg]. Misuse: an entry that is not finite, a
/// negative mass.
Matrix3d contact_inverse_mass(const ContactBody& a, const ContactBody& b, const Matrix3d& axes);

/// u = J v: velocity of b against a at the point of contact, along the columns of `axes` [m/s].
Vector3d contact_velocity(const ContactBody& a, const BodyVelocity& velocity_a, const ContactBody& b,
                          const BodyVelocity& velocity_b, const Matrix3d& axes);

/// The velocity of a body after an impulse [N s] in world axes at its point of contact (notes D1). An impulse
/// p along the contact axes acts as axes * p on b and as -axes * p on a.
BodyVelocity after_impulse(const ContactBody& body, const BodyVelocity& velocity, const Vector3d& impulse);

}  // namespace feder
