#pragma once

#include <memory>
#include <variant>

#include "engine/geometry/triangle_mesh.h"

namespace feder {

/// Where a shape is: a point s of it is at position + rotation s.
struct Pose {
  Matrix3d rotation = Matrix3d::Identity();
  Vector3d position = Vector3d::Zero();  ///< [m]
};

// Solid shapes in axes of their own, centred at the origin [m].
struct SphereShape {
  double radius = 0.0;  ///< >= 0; 0 is a point
};
struct BoxShape {
  Vector3d half;  ///< half edges, > 0
};
/// All points within `radius` of the segment from -half_length to +half_length on z.
struct CapsuleShape {
  double radius = 0.0, half_length = 0.0;  ///< > 0, >= 0
};
/// Everything below z = 0.
struct HalfSpaceShape {};
/// Axis z; spheres and half spaces alone can touch it, for the others use its mesh.
struct TorusShape {
  double major = 0.0, minor = 0.0;  ///< circle radius > tube radius > 0
};
class CollisionMesh;  // engine/geometry/collision_mesh.h
/// A closed mesh with its bounding volume hierarchy, shared by all that use it.
struct MeshShape {
  std::shared_ptr<const CollisionMesh> mesh;
};

using Shape = std::variant<SphereShape, BoxShape, CapsuleShape, HalfSpaceShape, TorusShape, MeshShape>;

}  // namespace feder
