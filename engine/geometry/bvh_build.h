#pragma once

#include <cstdint>
#include <vector>

#include "engine/geometry/bounding_volumes.h"
#include "engine/geometry/triangle_mesh.h"

namespace feder {

/// A box to be sorted into a tree, in single precision: it decides where the tree branches, not what its
/// volumes are.
struct BuildItem {
  float min[3];
  std::int32_t id;
  float max[3];
  std::int32_t unused;
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
