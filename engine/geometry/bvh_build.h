#pragma once

#include <Eigen/Core>
#include <bit>
#include <cstdint>
#include <vector>

#include "engine/geometry/bounding_volumes.h"
#include "engine/geometry/triangle_mesh.h"

namespace feder {

/// A box to be sorted into a tree, in single precision: it decides where the tree branches, not what its
/// volumes are. Lanes 0 to 2 are x, y, z; lane 3 of `min` holds the bits of the id.
struct BuildItem {
  Eigen::Array4f min, max;

  std::int32_t id() const { return std::bit_cast<std::int32_t>(min[3]); }
};

/// Boxes [m], finite, scaled to the unit cube; ids are their positions.
std::vector<BuildItem> build_items(const std::vector<Aabb>& boxes);
/// Boxes of the triangles of a mesh with finite vertices and indices in range.
std::vector<BuildItem> build_items(const TriangleMesh& mesh);

/// As in BvhNode.
struct BvhLinks {
  std::int32_t first, count;
};

/// Branches of a binary tree over the items, top down by the surface area heuristic, at most `leaf` items in
/// a leaf; sorts the items in leaf order. At most kBvhDepth nodes deep.
std::vector<BvhLinks> build_branches(std::vector<BuildItem>& items, int leaf);

}  // namespace feder
