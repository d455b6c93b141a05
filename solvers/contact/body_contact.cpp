// Two bodies at a point of contact (notes D1, D3), n from a to b, r from each centre to the point:
//   u = R^T (v_b + w_b x r_b - v_a - w_a x r_a),   W = R^T (sum of 1/m E - [r]x I^-1 [r]x) R,
//   m v' = m v +- p,   I w' = I w +- r x p,  plus for b.
#include "solvers/contact/body_contact.h"

#include <Eigen/Geometry>
#include <cmath>

#include "engine/check.h"
#include "engine/contacts.h"
#include "engine/rotation.h"

namespace feder {
namespace {

Matrix3d inverse_mass_at_point(const ContactBody& body) {
  FEDER_CHECK(std::isfinite(body.inverse_mass) && body.inverse_mass >= 0.0, "inverse mass must be >= 0");
  FEDER_CHECK(body.inverse_inertia.allFinite() && body.arm.allFinite(), "inertia and arm must be finite");
  const Matrix3d arm = skew(body.arm);
  return body.inverse_mass * Matrix3d::Identity() + arm * body.inverse_inertia * arm.transpose();
}

Vector3d point_velocity(const ContactBody& body, const BodyVelocity& velocity) {
  return velocity.linear + velocity.angular.cross(body.arm);
}

}  // namespace

Matrix3d contact_axes(const Vector3d& normal) {
  FEDER_CHECK(std::abs(normal.norm() - 1.0) <= 1e-9, "a contact normal must be a unit vector");
  return contact_frame(normal.normalized()).transpose();
}

Matrix3d contact_inverse_mass(const ContactBody& a, const ContactBody& b, const Matrix3d& axes) {
  const Matrix3d W = axes.transpose() * (inverse_mass_at_point(a) + inverse_mass_at_point(b)) * axes;
  return 0.5 * (W + W.transpose());
}

Vector3d contact_velocity(const ContactBody& a, const BodyVelocity& velocity_a, const ContactBody& b,
                          const BodyVelocity& velocity_b, const Matrix3d& axes) {
  return axes.transpose() * (point_velocity(b, velocity_b) - point_velocity(a, velocity_a));
}

BodyVelocity after_impulse(const ContactBody& body, const BodyVelocity& velocity, const Vector3d& impulse) {
  return {velocity.linear + body.inverse_mass * impulse,
          velocity.angular + body.inverse_inertia * body.arm.cross(impulse)};
}

}  // namespace feder
