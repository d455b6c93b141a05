// Shapes, poses and certificates for the tests of contact points.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <vector>

#include "engine/geometry/collision_mesh.h"
#include "engine/geometry/manifold.h"
#include "tests/support/random.h"

namespace feder::test {

inline constexpr double kFar = 1e3;  // a margin that every pair of the tests is within

inline Matrix3d random_turn(Random& random) {
  return Eigen::AngleAxisd(random.uniform(-3.0, 3.0), random.vector().normalized()).toRotationMatrix();
}
inline Pose random_pose(Random& random, double size) {
  return {random_turn(random), random.vector(size)};
}
inline Vector3d positive(Random& random, double low = 0.2) {
  return {random.uniform(low, 1.0), random.uniform(low, 1.0), random.uniform(low, 1.0)};
}

inline std::vector<ContactPoint> contacts(const Shape& a, const Pose& pose_a, const Shape& b,
                                          const Pose& pose_b, double margin = kFar) {
  std::vector<ContactPoint> out;
  find_contacts(a, pose_a, b, pose_b, margin, out);
  return out;
}

inline ContactPoint deepest(const std::vector<ContactPoint>& points) {
  return *std::min_element(points.begin(), points.end(),
                           [](const ContactPoint& x, const ContactPoint& y) { return x.gap < y.gap; });
}

inline Pose moved(const Pose& pose, const Matrix3d& rotation, const Vector3d& translation) {
  return {rotation * pose.rotation, rotation * pose.position + translation};
}

/// A turn and a shift by at most `size` [rad, m].
inline Pose nudged(const Pose& pose, double size, Random& random) {
  const Vector3d turn = random.vector(size);
  const Matrix3d rotation = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  return {rotation * pose.rotation, pose.position + random.vector(size)};
}

/// Distance of a point from the solid, exact: independent of the routines of pairs.
inline double outside(const Shape& shape, const Pose& pose, const Vector3d& x) {
  const Vector3d p = pose.rotation.transpose() * (x - pose.position);
  if (const auto* s = std::get_if<SphereShape>(&shape)) return std::max(0.0, p.norm() - s->radius);
  if (const auto* s = std::get_if<BoxShape>(&shape)) return (p.cwiseAbs() - s->half).cwiseMax(0.0).norm();
  if (const auto* s = std::get_if<CapsuleShape>(&shape)) {
    const double z = std::max(0.0, std::abs(p.z()) - s->half_length);
    return std::max(0.0, Vector3d(p.x(), p.y(), z).norm() - s->radius);
  }
  return std::max(0.0, p.z());
}

/// Largest n.x over a convex solid that is bounded.
inline double support(const Shape& shape, const Pose& pose, const Vector3d& n) {
  const Vector3d in = pose.rotation.transpose() * n;
  double out = n.dot(pose.position);
  if (const auto* s = std::get_if<SphereShape>(&shape)) out += s->radius * n.norm();
  if (const auto* s = std::get_if<BoxShape>(&shape)) out += in.cwiseAbs().dot(s->half);
  if (const auto* s = std::get_if<CapsuleShape>(&shape))
    out += s->half_length * std::abs(in.z()) + s->radius * n.norm();
  return out;
}

/// Separation of the solids along n. Its largest value is their distance, or minus the least translation that
/// parts them.
inline double separation(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                         const Vector3d& n) {
  return -support(b, pose_b, -n) - support(a, pose_a, n);
}

/// Whether two manifolds differ in their features, and otherwise how far their points and gaps are apart.
struct Change {
  bool features = false;
  double point = 0.0, gap = 0.0;
};
inline Change difference(const std::vector<ContactPoint>& before, const std::vector<ContactPoint>& after) {
  Change out{before.size() != after.size()};
  for (std::size_t k = 0; k < before.size() && !out.features; ++k) {
    out.features = before[k].feature != after[k].feature;
    out.point = std::max(out.point, (before[k].point - after[k].point).norm());
    out.gap = std::max(out.gap, std::abs(before[k].gap - after[k].gap));
  }
  return out;
}

inline std::shared_ptr<const CollisionMesh> box_surface(const Vector3d& half) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.push_back(half.cwiseProduct(Vector3d(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  mesh.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  return std::make_shared<CollisionMesh>("box", mesh);
}

inline std::shared_ptr<const CollisionMesh> torus_surface(const TorusShape& torus, int around, int across) {
  TriangleMesh mesh;
  const double step = 2.0 * std::numbers::pi;
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double u = step * i / around, v = step * j / across,
                   rho = torus.major + torus.minor * std::cos(v);
      mesh.vertices.emplace_back(rho * std::cos(u), rho * std::sin(u), torus.minor * std::sin(v));
      const int next_i = (i + 1) % around, next_j = (j + 1) % across;
      const int p = i * across + j, q = next_i * across + j, r = next_i * across + next_j,
                s = i * across + next_j;
      mesh.triangles.push_back({p, q, r});
      mesh.triangles.push_back({p, r, s});
    }
  return std::make_shared<CollisionMesh>("torus", mesh);
}

}  // namespace feder::test
