#pragma once

#include <array>
#include <optional>

#include "engine/geometry/collision_mesh.h"
#include "engine/geometry/shape.h"

namespace feder {

/// The surface of a solid nearest to a point; all in the world.
struct SolidPoint {
  Vector3d outward;  ///< unit, the way out of the solid there
  double distance;   ///< of the point along it, < 0 inside [m]
};

/// An edge in the world [m].
struct SolidEdge {
  Vector3d from, along;  ///< one end, unit vector to the other
  double length;
};

/// A mesh in the world, or a box as a mesh: the cube of edge 2, stretched to its half edges. Keeps
/// references.
class MeshSolid {
 public:
  MeshSolid(const CollisionMesh& mesh, const Pose& pose);
  MeshSolid(const BoxShape& box, const Pose& pose);

  const CollisionMesh& mesh() const { return mesh_; }
  /// Largest coordinate in its own axes [m].
  double size() const { return size_; }
  Vector3d vertex(int v) const { return pose_.position + pose_.rotation * local(v); }
  Vector3d turned(const Vector3d& v) const { return pose_.rotation * v; }
  SolidEdge edge(int e) const;
  /// Whether the solid is less than half of the space around an edge; a flat edge is not convex.
  bool convex(int e) const;
  Vector3d edge_normal(int e) const { return turned(mesh_.edge_normals()[e]); }
  /// Across an edge into the faces at it; unit.
  std::array<Vector3d, 2> beside(int e) const;

  /// A box around this solid in the axes of `other`, and around triangle t of `other` in axes of this one;
  /// `margin` larger [m].
  Aabb bounds_in(const MeshSolid& other, double margin) const;
  Aabb bounds_of(const MeshSolid& other, int t, double margin) const;
  /// visit(triangle) for those whose boxes meet `box`, in the axes of this solid [m].
  template <class Visitor>
  void visit_triangles(const Aabb& box, Visitor&& visit) const {
    mesh_.visit_triangles({box.min.cwiseQuotient(stretch_), box.max.cwiseQuotient(stretch_)}, visit);
  }

  /// Empty where x is further than `margin` outside. At an edge or vertex of the surface, the face there that
  /// looks most against `facing`, the way out of the other solid at x (zero: no preference); empty, too,
  /// where x is outside and the surface looks the same way as `facing`.
  std::optional<SolidPoint> nearest(const Vector3d& x, const Vector3d& facing, double margin) const;

 private:
  Vector3d local(int v) const { return mesh_.mesh().vertices[v].cwiseProduct(stretch_); }
  Vector3d into(const Vector3d& x) const { return pose_.rotation.transpose() * (x - pose_.position); }
  void face_other(const Vector3d& p, const Vector3d& way, const Vector3d& on_surface, SolidPoint& out) const;
  // The surface nearest to p, in axes of this solid.
  SolidPoint nearest_of_mesh(const Vector3d& p, Vector3d& on_surface) const;
  SolidPoint nearest_of_box(const Vector3d& p, Vector3d& on_surface) const;

  const CollisionMesh& mesh_;
  const Pose& pose_;
  Vector3d stretch_;
  bool box_;
  double size_;
};

}  // namespace feder
