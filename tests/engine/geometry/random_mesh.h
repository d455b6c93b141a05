// Meshes of random triangles and random poses for the tests of hierarchies.
#pragma once

#include <Eigen/Geometry>

#include "engine/geometry/shape.h"
#include "engine/geometry/triangle_overlap.h"
#include "tests/support/random.h"

namespace feder::test {

/// Soup of `count` triangles of edge about `size` in a cube of half edge 1; a fifth of them share a corner
/// with the one before, a tenth are segments or points.
inline TriangleMesh random_soup(Random& random, int count, double size) {
  TriangleMesh mesh;
  for (int k = 0; k < count; ++k) {
    const Vector3d centre = random.vector();
    const int first = static_cast<int>(mesh.vertices.size());
    std::array<int, 3> triangle{first, first + 1, first + 2};
    for (int c = 0; c < 3; ++c) mesh.vertices.push_back(centre + random.vector(size));
    if (k > 0 && random.below(5) == 0) triangle[0] = mesh.triangles.back()[random.below(3)];
    if (random.below(20) == 0) triangle[2] = triangle[1];
    if (random.below(20) == 0) triangle[1] = triangle[0];
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

/// Turned by any angle, or not at all in a quarter of the cases; moved by at most `reach` per axis.
inline Pose random_pose(Random& random, double reach) {
  Pose pose;
  pose.position = random.vector(reach);
  if (random.below(4) > 0) {
    Eigen::Quaterniond q(random.uniform(), random.uniform(), random.uniform(), random.uniform());
    pose.rotation = q.normalized().toRotationMatrix();
  }
  return pose;
}

/// From one triangle to a few hundred, small numbers as often as large ones.
inline int random_count(Random& random) {
  return 1 + random.below(1 << (1 + random.below(9)));
}

inline Triangle corners_of(const TriangleMesh& mesh, int triangle) {
  const auto& [i, j, k] = mesh.triangles[static_cast<std::size_t>(triangle)];
  return {mesh.vertices[static_cast<std::size_t>(i)], mesh.vertices[static_cast<std::size_t>(j)],
          mesh.vertices[static_cast<std::size_t>(k)]};
}

}  // namespace feder::test
