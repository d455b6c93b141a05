#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/geometry/bvh.h"
#include "engine/geometry/bvh_volumes.h"

namespace feder {

/// leaf(node_a, node_b) for every two leaves, one below root_a and one below root_b, on whose paths
/// apart(volume_a, volume_b) was false; stops and returns true as soon as leaf does. Notes A18 with the case
/// its listing drops: where one node is a leaf the other is descended, where neither is the larger.
template <class Volume, class Apart, class Leaf>
bool visit_leaf_pairs(const std::vector<BvhNode<Volume>>& a, int root_a,
                      const std::vector<BvhNode<Volume>>& b, int root_b, Apart&& apart, Leaf&& leaf) {
  struct Pair {
    std::int32_t a, b;
  };
  if (apart(a[root_a].volume, b[root_b].volume)) return false;
  std::array<Pair, 2 * kBvhDepth> stack{Pair{root_a, root_b}};
  for (int top = 1; top > 0;) {
    const Pair pair = stack[--top];
    const BvhNode<Volume>&x = a[pair.a], &y = b[pair.b];
    if (x.count > 0 && y.count > 0) {
      if (leaf(x, y)) return true;
    } else if (y.count > 0 || (x.count == 0 && size_of(x.volume) >= size_of(y.volume))) {
      for (std::int32_t child = x.first + 1; child >= x.first; --child)
        if (!apart(a[child].volume, y.volume)) stack[top++] = {child, pair.b};
    } else {
      for (std::int32_t child = y.first + 1; child >= y.first; --child)
        if (!apart(x.volume, b[child].volume)) stack[top++] = {pair.a, child};
    }
  }
  return false;
}

/// The same for the leaves of one tree: leaf(node, node) for each of them, and every two of them once.
template <class Volume, class Apart, class Leaf>
void visit_leaf_pairs(const std::vector<BvhNode<Volume>>& nodes, Apart&& apart, Leaf&& leaf) {
  for (const BvhNode<Volume>& node : nodes)
    if (node.count > 0)
      leaf(node, node);
    else
      visit_leaf_pairs(nodes, node.first, nodes, node.first + 1, apart, leaf);
}

}  // namespace feder
