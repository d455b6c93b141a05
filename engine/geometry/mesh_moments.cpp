// Signed tetrahedra (0, a, b, c) with D = a.(b x c) = a.((b - a) x (c - a)) and s = a + b + c:
//   V = sum D/6,   integral of x = sum D/24 s,
//   integral of x x^T = sum D/120 (a a^T + b b^T + c c^T + s s^T)
// (notes C9; Blow and Binstock, How to find the inertia tensor of a 3D solid body represented by a mesh,
// 2004).
#include "engine/geometry/mesh_moments.h"

namespace feder {

MeshMoments mesh_moments(const TriangleMesh& mesh, const Vector3d& origin) {
  MeshMoments out;
  for (const std::array<int, 3>& t : mesh.triangles) {
    if (repeats_an_index(t)) continue;
    const Vector3d &p = mesh.vertices[t[0]], &q = mesh.vertices[t[1]], &r = mesh.vertices[t[2]];
    const Vector3d a = p - origin, b = q - origin, c = r - origin, s = a + b + c;
    const Vector3d normal = (q - p).cross(r - p);
    const double D = a.dot(normal);
    out.area += 0.5 * normal.norm();
    out.volume += D / 6.0;
    out.first += D / 24.0 * s;
    out.second += D / 120.0 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose());
  }
  return out;
}

bool repeats_an_index(const std::array<int, 3>& t) {
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

Eigen::AlignedBox3d used_bounds(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d bounds;
  for (const std::array<int, 3>& t : mesh.triangles)
    for (int vertex : t) bounds.extend(mesh.vertices[vertex]);
  return bounds;
}

}  // namespace feder
