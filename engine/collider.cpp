#include "engine/collider.h"

#include "engine/geometry/shape_bounds.h"
#include "engine/system.h"

namespace feder {

void Collider::resolve(const System& s) {
  if (at.body < 0) {
    place = {at.node};
    fixed = s.free[at.node] == kPinned;
  } else {
    const Body& b = s.bodies[at.body];
    place = {b.centre, b.spin, b.quaternion, b.axes.transpose() * (at.point - b.centre_point)};
    rotation = b.axes.transpose() * rotation;
    fixed = s.free[b.centre] == kPinned && s.free[b.spin] == kPinned;
  }
}

Pose Collider::pose(const double* q) const {
  const Eigen::Map<const Vector3d> centre(q + 3 * place.node);
  if (place.spin < 0) return {rotation, centre};
  const Matrix3d R = feder::rotation(place, q);
  return {R * rotation, centre + R * place.point};
}

double Collider::reach() const {
  return bounding_radius(shape);
}

}  // namespace feder
