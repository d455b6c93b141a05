#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "engine/geometry/bvh.h"
#include "engine/geometry/shape.h"

namespace feder {

// Queries for Volume = Sphere, Aabb and Obb. Triangles are named by their index in the mesh; touching counts
// as meeting.

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

}  // namespace feder
