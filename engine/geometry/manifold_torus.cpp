// A torus is the union of the balls of its tube radius r about the points of a circle of radius R (axis z):
//   centre c of another ball:  circle point R (c_x, c_y)/rho, distance sqrt((rho - R)^2 + c_z^2) - r
//   half space with normal u:  lowest circle point -R (u_x, u_y)/rho, height u.x - R rho - r
// Where rho is small against R (flat on the plane, centred in the hole) many balls of the circle are nearly
// as close: four of them, fixed to the torus, then hold it, and the closest joins in where it is closer
// still.
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/geometry/manifold_pairs.h"

namespace feder {
namespace {

constexpr double kCentred = 0.1;   // rho below this: four fixed balls
constexpr double kCloser = 1e-10;  // what the closest ball gains over them counts from here on, relative to R

constexpr double kRounding = 1e-14;

/// Calls add(direction, feature) for the balls of the circle to look at; `toward`: where the closest lies, of
/// length rho; gap(direction): its distance, up to a constant.
template <class Gap, class Add>
void visit_ring(double major, double toward_x, double toward_y, Gap&& gap, Add&& add) {
  const double rho = std::hypot(toward_x, toward_y);
  const Vector3d closest =
      rho > 0.0 ? Vector3d(toward_x / rho, toward_y / rho, 0.0) : Vector3d(Vector3d::UnitX());
  double least = std::numeric_limits<double>::infinity();
  if (rho < kCentred)
    for (int k = 0; k < 4; ++k) {
      const Vector3d fixed = (k < 2 ? 1.0 : -1.0) * Vector3d::Unit(k % 2);
      least = std::min(least, gap(fixed));
      add(fixed, static_cast<std::uint32_t>(k + 1));
    }
  if (!(gap(closest) >= least - kCloser * major)) add(closest, 0u);
}

}  // namespace

void add_contacts(const SphereShape& sphere, const Pose& sphere_pose, const TorusShape& torus,
                  const Pose& pose, ContactSink& sink) {
  const Vector3d centre = pose.rotation.transpose() * (sphere_pose.position - pose.position);
  visit_ring(
      torus.major, centre.x() / torus.major, centre.y() / torus.major,
      [&](const Vector3d& direction) { return (torus.major * direction - centre).norm(); },
      [&](const Vector3d& direction, std::uint32_t feature) {
        const Vector3d on_circle = pose.position + pose.rotation * (torus.major * direction);
        add_balls(sphere_pose.position, sphere.radius, on_circle, torus.minor, -pose.rotation.col(2),
                  kRounding * torus.major, feature, sink);
      });
}

void add_contacts(const HalfSpaceShape&, const Pose& plane, const TorusShape& torus, const Pose& pose,
                  ContactSink& sink) {
  const Vector3d up = plane.rotation.col(2), in_torus = pose.rotation.transpose() * up;
  const double height = up.dot(pose.position - plane.position);
  visit_ring(
      torus.major, -in_torus.x(), -in_torus.y(),
      [&](const Vector3d& direction) { return torus.major * direction.dot(in_torus); },
      [&](const Vector3d& direction, std::uint32_t feature) {
        const double gap = height + torus.major * direction.dot(in_torus) - torus.minor;
        const Vector3d lowest = pose.position + pose.rotation * (torus.major * direction) - torus.minor * up;
        sink.add(lowest - gap * up, up, gap, feature);
      });
}

}  // namespace feder
