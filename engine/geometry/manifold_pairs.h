#pragma once

#include <cstdint>
#include <vector>

#include "engine/geometry/manifold.h"

namespace feder {

/// Where the routine of a pair puts its contact points.
struct ContactSink {
  double margin;  ///< [m]
  std::vector<ContactPoint>& out;

  /// `on_a` is on the surface of a, the surface of b is `gap` along the normal away.
  void add(const Vector3d& on_a, const Vector3d& normal, double gap, std::uint32_t feature) {
    if (gap <= margin) out.push_back({on_a + 0.5 * gap * normal, normal, gap, feature});
  }
};

/// Feature of a pair of convex shapes, from numbers below 2^16 for the feature of each.
constexpr std::uint32_t feature_pair(std::uint32_t of_a, std::uint32_t of_b) {
  return of_a << 16 | of_b;
}

/// Unit vector along v, or `fallback` where v is zero.
Vector3d direction_or(const Vector3d& v, const Vector3d& fallback);

/// Contact of two balls; `fallback` is the normal where the centres are no more than `rounding` [m] apart.
void add_balls(const Vector3d& centre_a, double radius_a, const Vector3d& centre_b, double radius_b,
               const Vector3d& fallback, double rounding, std::uint32_t feature, ContactSink& sink);

// One routine per pair, in the order of the types in Shape; points come in any order.
// manifold_rounded.cpp
void add_contacts(const SphereShape&, const Pose&, const SphereShape&, const Pose&, ContactSink&);
void add_contacts(const SphereShape&, const Pose&, const BoxShape&, const Pose&, ContactSink&);
void add_contacts(const SphereShape&, const Pose&, const CapsuleShape&, const Pose&, ContactSink&);
void add_contacts(const CapsuleShape&, const Pose&, const CapsuleShape&, const Pose&, ContactSink&);
// manifold_torus.cpp
void add_contacts(const SphereShape&, const Pose&, const TorusShape&, const Pose&, ContactSink&);
void add_contacts(const HalfSpaceShape&, const Pose&, const TorusShape&, const Pose&, ContactSink&);
// manifold_boxes.cpp
void add_contacts(const BoxShape&, const Pose&, const BoxShape&, const Pose&, ContactSink&);
void add_contacts(const BoxShape&, const Pose&, const CapsuleShape&, const Pose&, ContactSink&);
// manifold_half_space.cpp
void add_contacts(const SphereShape&, const Pose&, const HalfSpaceShape&, const Pose&, ContactSink&);
void add_contacts(const BoxShape&, const Pose&, const HalfSpaceShape&, const Pose&, ContactSink&);
void add_contacts(const CapsuleShape&, const Pose&, const HalfSpaceShape&, const Pose&, ContactSink&);

// manifold_mesh.cpp
void add_contacts(const HalfSpaceShape&, const Pose&, const MeshShape&, const Pose&, ContactSink&);
void add_contacts(const SphereShape&, const Pose&, const MeshShape&, const Pose&, ContactSink&);
void add_contacts(const CapsuleShape&, const Pose&, const MeshShape&, const Pose&, ContactSink&);
// manifold_polyhedra.cpp
void add_contacts(const BoxShape&, const Pose&, const MeshShape&, const Pose&, ContactSink&);
void add_contacts(const MeshShape&, const Pose&, const MeshShape&, const Pose&, ContactSink&);

}  // namespace feder
