// Sign of the distance by angle-weighted pseudo-normals (Baerentzen and Aanaes, Signed distance computation
// using the angle weighted pseudonormal, 2005): with c the point of the surface nearest to p,
//   sign (p - c).n,   n = face normal, sum of both at an edge, sum of angle times normal at a vertex.
#include "engine/geometry/collision_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <compare>
#include <limits>

#include "engine/check.h"
#include "engine/geometry/bvh_queries.h"
#include "engine/geometry/mesh_check.h"

namespace feder {

CollisionMesh::CollisionMesh(const std::string& where, TriangleMesh mesh)
    : mesh_((check_closed_mesh(where, mesh), std::move(mesh))), hierarchy_(mesh_) {
  find_face_and_vertex_normals(where);
  find_edges();
}

void CollisionMesh::find_face_and_vertex_normals(const std::string& where) {
  face_normals_.resize(mesh_.triangles.size());
  vertex_normals_.assign(mesh_.vertices.size(), Vector3d::Zero());
  for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
    const std::array<int, 3>& corner = mesh_.triangles[t];
    const Vector3d edge[3] = {mesh_.vertices[corner[1]] - mesh_.vertices[corner[0]],
                              mesh_.vertices[corner[2]] - mesh_.vertices[corner[1]],
                              mesh_.vertices[corner[0]] - mesh_.vertices[corner[2]]};
    const Vector3d area = edge[0].cross(edge[1]);
    const double size = area.norm();
    if (!(size > 0.0))
      fail_input(where + ", triangle " + std::to_string(t), "area", 0.5 * size, "m^2", "a value > 0");
    face_normals_[t] = area / size;
    for (int k = 0; k < 3; ++k) {
      const double angle = std::atan2(size, -edge[k].dot(edge[(k + 2) % 3]));
      vertex_normals_[corner[k]] += angle * face_normals_[t];
    }
  }
  for (Vector3d& n : vertex_normals_) n.normalize();
}

// Both triangles of every edge: neighbours in the order of the vertices, the one from a to b first.
void CollisionMesh::find_edges() {
  struct Side {
    int a, b;
    bool back;
    int triangle, k;
    auto operator<=>(const Side&) const = default;
  };
  std::vector<Side> sides;
  sides.reserve(3 * mesh_.triangles.size());
  for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const int from = mesh_.triangles[t][k], to = mesh_.triangles[t][(k + 1) % 3];
      sides.push_back({std::min(from, to), std::max(from, to), from > to, static_cast<int>(t), k});
    }
  std::sort(sides.begin(), sides.end());
  triangle_edges_.resize(mesh_.triangles.size());
  edges_.reserve(sides.size() / 2);
  edge_normals_.reserve(sides.size() / 2);
  for (std::size_t i = 0; i < sides.size(); i += 2) {
    const Side &left = sides[i], &right = sides[i + 1];
    triangle_edges_[left.triangle][left.k] = triangle_edges_[right.triangle][right.k] =
        static_cast<int>(edges_.size());
    edges_.push_back({left.a, left.b, left.triangle, right.triangle});
    edge_normals_.push_back((face_normals_[left.triangle] + face_normals_[right.triangle]).normalized());
  }
}

std::optional<SurfacePoint> CollisionMesh::closest_point(const Vector3d& p, double margin) const {
  const std::optional<MeshPoint> nearest = feder::closest_point(hierarchy_, p, margin);
  if (!nearest) return std::nullopt;
  const int t = nearest->triangle, k = nearest->local;
  SurfacePoint out{nearest->point, {}, std::sqrt(nearest->distance_squared), t, nearest->feature, t};
  if (out.feature == Feature::kEdge) out.index = edge_of(t, k);
  if (out.feature == Feature::kVertex) out.index = mesh_.triangles[t][k];
  const std::vector<Vector3d>& normals = out.feature == Feature::kFace   ? face_normals_
                                         : out.feature == Feature::kEdge ? edge_normals_
                                                                         : vertex_normals_;
  out.normal = normals[out.index];
  if (out.normal.dot(p - out.point) < 0.0) out.signed_distance = -out.signed_distance;
  return out;
}

}  // namespace feder
