#pragma once

#include <Eigen/Geometry>

#include "engine/geometry/triangle_mesh.h"

namespace feder {

/// Integrals over the inside of a closed mesh, about one origin; the area is that of its surface.
struct MeshMoments {
  double volume = 0.0;                 ///< [m^3]; < 0: inside out
  double area = 0.0;                   ///< [m^2]
  Vector3d first = Vector3d::Zero();   ///< integral of x dV [m^4]
  Matrix3d second = Matrix3d::Zero();  ///< integral of x x^T dV [m^5]
};

/// Indices must be in range. A triangle that repeats an index counts nothing.
MeshMoments mesh_moments(const TriangleMesh& mesh, const Vector3d& origin);

/// A triangle without area because of an index named twice: skipped by whatever reads a mesh.
bool repeats_an_index(const std::array<int, 3>& triangle);

/// Bounding box of the vertices that triangles use; empty without triangles. Indices must be in range.
Eigen::AlignedBox3d used_bounds(const TriangleMesh& mesh);

}  // namespace feder
