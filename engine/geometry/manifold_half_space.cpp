// Contacts with a half space: the lowest points of the other solid. With unit normal u of the plane and a
// point o of it, a point x is u.(x - o) above the plane; the normal of the contact is -u.
#include "engine/geometry/manifold_pairs.h"

namespace feder {
namespace {

struct Plane {
  Vector3d up, origin;

  explicit Plane(const Pose& pose) : up(pose.rotation.col(2)), origin(pose.position) {}
  /// The lowest point of a ball.
  void add_ball(const Vector3d& centre, double radius, std::uint32_t feature, ContactSink& sink) const {
    sink.add(centre - radius * up, -up, up.dot(centre - origin) - radius, feature);
  }
};

}  // namespace

void add_contacts(const SphereShape& sphere, const Pose& pose, const HalfSpaceShape&, const Pose& plane,
                  ContactSink& sink) {
  Plane(plane).add_ball(pose.position, sphere.radius, 0, sink);
}

void add_contacts(const BoxShape& box, const Pose& pose, const HalfSpaceShape&, const Pose& plane_pose,
                  ContactSink& sink) {
  const Plane plane(plane_pose);
  for (std::uint32_t k = 0; k < 8; ++k) {
    const Vector3d sign(k & 1 ? 1.0 : -1.0, k & 2 ? 1.0 : -1.0, k & 4 ? 1.0 : -1.0);
    plane.add_ball(pose.position + pose.rotation * sign.cwiseProduct(box.half), 0.0, k, sink);
  }
}

void add_contacts(const CapsuleShape& capsule, const Pose& pose, const HalfSpaceShape&,
                  const Pose& plane_pose, ContactSink& sink) {
  const Plane plane(plane_pose);
  const Vector3d along = capsule.half_length * pose.rotation.col(2);
  plane.add_ball(pose.position - along, capsule.radius, 0, sink);
  if (capsule.half_length > 0.0) plane.add_ball(pose.position + along, capsule.radius, 1, sink);
}

}  // namespace feder
