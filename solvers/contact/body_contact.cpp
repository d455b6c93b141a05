// Two bodies at a point of contact (notes D1, D3), n from a to b, r from each centre to the point:
//   u = R^T (v_b + w_b x r_b - v_a - w_a x r_a),   W = R^T (sum of 1/m E - [r]x I^-1 [r]x) R,
//   m v' = m v +- p,   I w' = I w +- r x p,  plus for b.
#include "solvers/contact/body_contact.h"

#include <Eigen/Geometry>
#include <cmath>

#include "engine/check.h"

namespace feder {
namespace {

Matrix3d inverse_mass_at_point(const ContactBody& body) {
  FEDER_CHECK(std::isfinite(body.inverse_mass) && body.inverse_mass >= 0.0, "inverse mass must be >= 0");
  FEDER_CHECK(body.inverse_inertia.allFinite() && body.arm.allFinite(), "inertia and arm must be finite");
  const Vector3d& r = body.arm;
  Matrix3d skew;
  skew << 0.0, -r[2], r[1], r[2], 0.0, -r[0], -r[1], r[0], 0.0;
  return body.inverse_mass * Matrix3d::Identity() + skew * body.inverse_inertia * skew.transpose();
}

Vector3d point_velocity(const ContactBody& body, const BodyVelocity& velocity) {
  return velocity.linear + velocity.angular.cross(body.arm);
}

}  // namespace

Matrix3d contact_axes(const Vector3d& normal) {
  FEDER_CHECK(std::abs(normal.norm() - 1.0) <= 1e-9, "a contact normal must be a unit vector");
  // The first tangent is normal to the coordinate axis farthest from n.
  int axis = 0;
  normal.cwiseAbs().minCoeff(&axis);
  Matrix3d axes;
  axes.col(0) = normal.normalized();
  axes.col(1) = axes.col(0).cross(Vector3d::Unit(axis)).normalized();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes;
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
