// Sign of the distance by angle-weighted pseudo-normals (Baerentzen and Aanaes, Signed distance computation
// using the angle weighted pseudonormal, 2005): with c the point of the surface nearest to p,
//   sign (p - c).n,   n = face normal, sum of both at an edge, sum of angle times normal at a vertex.
#include "engine/geometry/collision_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/check.h"
#include "engine/geometry/bvh_queries.h"

namespace feder {

CollisionMesh::CollisionMesh(const std::string& where, TriangleMesh mesh)
    : mesh_(std::move(mesh)), hierarchy_(mesh_) {
  if (mesh_.triangles.empty()) fail_input(where, "number of triangles", 0, "", "a closed mesh");
  find_edges(where);
  find_normals(where);
}

// Both triangles of every edge.
void CollisionMesh::find_edges(const std::string& where) {
  struct Side {
    int a, b, triangle, k;
    bool forward;
  };
  std::vector<Side> sides;
  sides.reserve(3 * mesh_.triangles.size());
  for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const int from = mesh_.triangles[t][k], to = mesh_.triangles[t][(k + 1) % 3];
      sides.push_back({std::min(from, to), std::max(from, to), static_cast<int>(t), k, from < to});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& x, const Side& y) {
    return std::tie(x.a, x.b, y.forward, x.triangle) < std::tie(y.a, y.b, x.forward, y.triangle);
  });
  triangle_edges_.resize(mesh_.triangles.size());
  edges_.reserve(sides.size() / 2);
  for (std::size_t i = 0; i < sides.size(); i += 2) {
    const Side& left = sides[i];
    const bool closed = i + 1 < sides.size() && sides[i + 1].a == left.a && sides[i + 1].b == left.b &&
                        left.forward && !sides[i + 1].forward;
    if (!closed)
      fail_input(where + ", edge (" + std::to_string(left.a) + ", " + std::to_string(left.b) + ")",
                 "triangle", left.triangle, "",
                 "a closed mesh, two triangles with opposite directions at every edge");
    const Side& right = sides[i + 1];
    triangle_edges_[left.triangle][left.k] = triangle_edges_[right.triangle][right.k] =
        static_cast<int>(edges_.size());
    edges_.push_back({left.a, left.b, left.triangle, right.triangle});
  }
}

void CollisionMesh::find_normals(const std::string& where) {
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
  edge_normals_.reserve(edges_.size());
  for (const MeshEdge& edge : edges_)
    edge_normals_.push_back((face_normals_[edge.left] + face_normals_[edge.right]).normalized());
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
