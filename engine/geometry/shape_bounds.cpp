// Bounds of shapes. A box of half edges h turned by R fills |R| h (entry by entry); a ball around it adds its
// radius. Torus about the unit axis a: a circle of radius r reaches r sqrt(1 - a_i^2) along axis i.
#include "engine/geometry/shape_bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/check.h"
#include "engine/geometry/collision_mesh.h"

namespace feder {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

template <class... Case>
struct Overloaded : Case... {
  using Case::operator()...;
};
template <class... Case>
Overloaded(Case...) -> Overloaded<Case...>;

Aabb around(const Vector3d& centre, const Vector3d& half) {
  return {centre - half, centre + half};
}

}  // namespace

Aabb bounds(const Shape& shape, const Pose& pose) {
  const Matrix3d& R = pose.rotation;
  return std::visit(
      Overloaded{
          [&](const SphereShape& s) { return around(pose.position, Vector3d::Constant(s.radius)); },
          [&](const BoxShape& s) { return around(pose.position, R.cwiseAbs() * s.half); },
          [&](const CapsuleShape& s) {
            return around(pose.position, (s.half_length * R.col(2).cwiseAbs()).array() + s.radius);
          },
          [&](const HalfSpaceShape&) { return around(Vector3d::Zero(), Vector3d::Constant(kInfinite)); },
          [&](const TorusShape& s) {
            const Vector3d circle = (1.0 - R.col(2).cwiseAbs2().array()).cwiseMax(0.0).sqrt() * s.major;
            return around(pose.position, circle.array() + s.minor);
          },
          [&](const MeshShape& s) {
            const Aabb box = s.mesh->hierarchy().nodes().front().volume;
            const Vector3d half = 0.5 * (box.max - box.min);
            return around(pose.position + R * (0.5 * (box.max + box.min)), R.cwiseAbs() * half);
          }},
      shape);
}

double bounding_radius(const Shape& shape) {
  return std::visit(Overloaded{[](const SphereShape& s) { return s.radius; },
                               [](const BoxShape& s) { return s.half.norm(); },
                               [](const CapsuleShape& s) { return s.radius + s.half_length; },
                               [](const HalfSpaceShape&) { return kInfinite; },
                               [](const TorusShape& s) { return s.major + s.minor; },
                               [](const MeshShape& s) {
                                 const Aabb box = s.mesh->hierarchy().nodes().front().volume;
                                 return box.min.cwiseAbs().cwiseMax(box.max.cwiseAbs()).norm();
                               }},
                    shape);
}

void check_shape(const std::string& where, const Shape& shape) {
  std::visit(Overloaded{[&](const SphereShape& s) { require_non_negative(where, "radius", s.radius, "m"); },
                        [&](const BoxShape& s) {
                          for (int c = 0; c < 3; ++c)
                            require_positive(where, std::string("half edge ") + "xyz"[c], s.half[c], "m");
                        },
                        [&](const CapsuleShape& s) {
                          require_positive(where, "radius", s.radius, "m");
                          require_non_negative(where, "half length", s.half_length, "m");
                        },
                        [&](const HalfSpaceShape&) {},
                        [&](const TorusShape& s) {
                          require_positive(where, "minor radius", s.minor, "m");
                          require_finite(where, "major radius", s.major, "m");
                          if (!(s.major > s.minor))
                            fail_input(where, "major radius", s.major, "m", "a value above the minor radius");
                        },
                        [&](const MeshShape& s) {
                          if (!s.mesh)
                            throw InputError(where + ": mesh is missing, expected a CollisionMesh");
                        }},
             shape);
}

}  // namespace feder
