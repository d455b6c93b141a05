#pragma once

#include <array>
#include <vector>

#include "engine/state.h"

namespace feder {

/// A surface of triangles. The type promises nothing; read_mesh gives finite vertices and indices in range,
/// check_closed_mesh and solid_mesh check that it encloses a solid.
struct TriangleMesh {
  std::vector<Vector3d> vertices;             ///< [m]
  std::vector<std::array<int, 3>> triangles;  ///< vertex indices from 0, counter-clockwise seen from outside
};

}  // namespace feder
