#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "engine/geometry/bvh.h"
#include "engine/geometry/shape.h"
#include "engine/geometry/triangle_distance.h"

namespace feder {

// Queries for Volume = Sphere, Aabb and Obb. Triangles are named by their index in the mesh; touching counts
// as meeting.

using TrianglePair = std::pair<int, int>;

/// Any pair of triangles that meet, the hierarchies placed by their poses.
template <class Volume>
std::optional<TrianglePair> any_overlap(const Bvh<Volume>& a, const Pose& pose_a, const Bvh<Volume>& b,
                                        const Pose& pose_b);

/// Every pair of triangles that meet, sorted.
template <class Volume>
std::vector<TrianglePair> all_overlaps(const Bvh<Volume>& a, const Pose& pose_a, const Bvh<Volume>& b,
                                       const Pose& pose_b);

/// Every pair (i, j), i < j, of triangles of one mesh that meet and share no vertex, sorted.
template <class Volume>
std::vector<TrianglePair> self_overlaps(const Bvh<Volume>& mesh);

/// Nearest points of two surfaces, in the world [m]. Empty where a hierarchy is empty.
struct MeshDistance {
  Vector3d a, b;
  double distance;  ///< 0 where the surfaces meet [m]
  TrianglePair triangles;
};
template <class Volume>
std::optional<MeshDistance> closest_points(const Bvh<Volume>& a, const Pose& pose_a, const Bvh<Volume>& b,
                                           const Pose& pose_b);

/// A point of a surface near to another.
struct MeshPoint {
  Vector3d point;
  double distance_squared;  ///< [m^2]
  int triangle;
  Feature feature;  ///< of the triangle
  int local;        ///< which edge (from that corner on) or corner of it; 0 for the face
};
/// The point of the surface nearest to p [m] if it is at most `margin` away [m]; p finite, otherwise misuse.
template <class Volume>
std::optional<MeshPoint> closest_point(const Bvh<Volume>& mesh, const Vector3d& p, double margin);

struct RayHit {
  double t;  ///< the point is origin + t direction
  int triangle;
};
/// First triangle on the way from t = 0 to `limit`, seen from either side; direction of any length, finite.
template <class Volume>
std::optional<RayHit> first_hit(const Bvh<Volume>& mesh, const Vector3d& origin, const Vector3d& direction,
                                double limit);

}  // namespace feder
