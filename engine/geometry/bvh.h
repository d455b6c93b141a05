#pragma once

#include <cstdint>
#include <vector>

#include "engine/geometry/bounding_volumes.h"
#include "engine/geometry/triangle_mesh.h"
#include "engine/geometry/triangle_overlap.h"

namespace feder {

/// Inner node (count == 0): its children are nodes first and first + 1, both after it. Leaf: the triangles at
/// positions first to first + count - 1.
template <class Volume>
struct BvhNode {
  Volume volume;  ///< contains every triangle below [m]
  std::int32_t first = 0, count = 0;
};

/// Bounding volume hierarchy over the triangles of a mesh; Volume is Sphere, Aabb or Obb. Node 0 is the root;
/// the triangles are kept in leaf order, each under a position. The hierarchy copies what it needs of the
/// mesh.
template <class Volume>
class Bvh {
 public:
  /// No triangle, no node: every query comes back empty.
  Bvh() = default;
  /// InputError: an index out of range or a vertex that is not finite. Degenerate triangles are allowed.
  explicit Bvh(const TriangleMesh& mesh);

  /// New places of the same vertices [m]: volumes follow, the tree stays. InputError: not finite; misuse:
  /// another number of vertices.
  void refit(const std::vector<Vector3d>& vertices);

  const std::vector<BvhNode<Volume>>& nodes() const { return nodes_; }
  int size() const { return static_cast<int>(order_.size()); }
  /// Index in the mesh of the triangle at a position.
  int triangle(int position) const { return order_[static_cast<std::size_t>(position)]; }
  /// Its vertex indices.
  const std::array<int, 3>& indices(int position) const {
    return sorted_.triangles[static_cast<std::size_t>(position)];
  }
  /// Its corners [m].
  Triangle corners(int position) const {
    const auto& [i, j, k] = indices(position);
    return {vertex(i), vertex(j), vertex(k)};
  }

 private:
  const Vector3d& vertex(int index) const { return sorted_.vertices[static_cast<std::size_t>(index)]; }

  std::vector<BvhNode<Volume>> nodes_;
  std::vector<int> order_;
  TriangleMesh sorted_;  // triangles by position
};

extern template class Bvh<Sphere>;
extern template class Bvh<Aabb>;
extern template class Bvh<Obb>;

/// Nodes on the way from the root to any leaf, at most: traversals need no more stack than one such path for
/// every tree they walk.
inline constexpr int kBvhDepth = 96;
/// Triangles in a leaf, at most.
inline constexpr int kBvhLeaf = 6;

}  // namespace feder
