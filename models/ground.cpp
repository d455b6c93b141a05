#include "models/ground.h"

#include <Eigen/Geometry>

#include "engine/contacts.h"
#include "engine/energy.h"

namespace feder {

Matrix3d axes_along(const Vector3d& n) {
  const Matrix3d frame = contact_frame(n);  // rows n, t1, t2 and right-handed
  Matrix3d axes;
  axes << frame.row(1).transpose(), frame.row(2).transpose(), frame.row(0).transpose();
  return axes;
}

void add_plane(SystemBuilder& builder, const Vector3d& point, const Vector3d& n, const Surface& surface) {
  builder.add_collider(builder.add_world_point(point), HalfSpaceShape{}, surface, 0, axes_along(n));
}

State moved_body(const State& start, const Body& b, double t, const Vector3d& axis,
                 const BodyMotion& motion) {
  State s = start;
  s.t = t;
  s.q.segment<3>(3 * b.centre) += motion.shift;
  s.v.segment<3>(3 * b.centre) = motion.velocity;
  const auto q = start.q.segment<4>(b.quaternion);
  const Eigen::Quaterniond before(q[0], q[1], q[2], q[3]);
  const Vector3d half = std::sin(0.5 * motion.angle) * axis;
  const Eigen::Quaterniond now =
      Eigen::Quaterniond(std::cos(0.5 * motion.angle), half.x(), half.y(), half.z()) * before;
  s.q.segment<4>(b.quaternion) << now.w(), now.x(), now.y(), now.z();
  // the axis is fixed in the body, too
  s.v.segment<3>(3 * b.spin) =
      motion.rate * (rotation_matrix(start.q.data() + b.quaternion).transpose() * axis);
  return s;
}

Conserved conserved_momentum(const std::string& name, int axis) {
  return {name, "kg m/s", [axis](const System& s, const State& at) { return linear_momentum(s, at)[axis]; }};
}

Conserved conserved_angular_momentum(const std::string& name, int axis) {
  return {name, "kg m^2/s",
          [axis](const System& s, const State& at) { return angular_momentum(s, at)[axis]; }};
}

}  // namespace feder
