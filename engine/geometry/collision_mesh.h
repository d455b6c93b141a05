#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/geometry/aabb.h"
#include "engine/geometry/bvh.h"
#include "engine/geometry/triangle_distance.h"

namespace feder {

/// An edge from vertex a to vertex b (a < b), met by two triangles: `left` runs along it from a to b, `right`
/// back.
struct MeshEdge {
  int a, b, left, right;
};

/// A point of a surface, seen from a point in space.
struct SurfacePoint {
  Vector3d point;          ///< [m]
  Vector3d normal;         ///< angle-weighted pseudo-normal there: unit, outward
  double signed_distance;  ///< of the point asked for; < 0 inside [m]
  int triangle;            ///< one that contains the point
  Feature feature;
  int index;  ///< of the triangle, of the edge in edges(), or of the vertex, as `feature` says
};

/// The surface of a solid for contact queries: mesh, hierarchy of boxes, unique edges, pseudo-normals.
/// Immutable.
class CollisionMesh {
 public:
  /// InputError naming `where` and the element: what check_closed_mesh refuses, and a triangle without area,
  /// which has no normal.
  CollisionMesh(const std::string& where, TriangleMesh mesh);

  const TriangleMesh& mesh() const { return mesh_; }
  const Bvh<Aabb>& hierarchy() const { return hierarchy_; }
  /// Ordered by (a, b).
  const std::vector<MeshEdge>& edges() const { return edges_; }
  /// Edge of triangle `triangle` from its corner k to the next, as an index in edges().
  int edge_of(int triangle, int k) const {
    return triangle_edges_[static_cast<std::size_t>(triangle)][static_cast<std::size_t>(k)];
  }
  // Unit outward normals; of a vertex that no triangle uses: zero.
  const std::vector<Vector3d>& face_normals() const { return face_normals_; }
  const std::vector<Vector3d>& edge_normals() const { return edge_normals_; }
  const std::vector<Vector3d>& vertex_normals() const { return vertex_normals_; }

  /// The point of the surface nearest to p [m], if it is at most `margin` away [m].
  std::optional<SurfacePoint> closest_point(const Vector3d& p, double margin) const;

  /// visit(triangle) for every triangle whose box meets `box`, in an order that only depends on mesh and box.
  template <class Visitor>
  void visit_triangles(const Aabb& box, Visitor&& visit) const;

 private:
  void find_face_and_vertex_normals(const std::string& where);
  void find_edges();

  TriangleMesh mesh_;
  Bvh<Aabb> hierarchy_;
  std::vector<MeshEdge> edges_;
  std::vector<std::array<int, 3>> triangle_edges_;
  std::vector<Vector3d> face_normals_, edge_normals_, vertex_normals_;
};

template <class Visitor>
void CollisionMesh::visit_triangles(const Aabb& box, Visitor&& visit) const {
  const auto& nodes = hierarchy_.nodes();
  if (nodes.empty()) return;
  std::array<std::int32_t, kBvhDepth> stack{0};
  for (int top = 1; top > 0;) {
    const BvhNode<Aabb>& node = nodes[static_cast<std::size_t>(stack[static_cast<std::size_t>(--top)])];
    if (!overlap(box, node.volume)) continue;
    if (node.count == 0) {
      stack[static_cast<std::size_t>(top++)] = node.first + 1;
      stack[static_cast<std::size_t>(top++)] = node.first;
    }
    for (int k = node.first; k < node.first + node.count; ++k)
      if (overlap(box, fit_aabb(hierarchy_.corners(k)))) visit(hierarchy_.triangle(k));
  }
}

}  // namespace feder
