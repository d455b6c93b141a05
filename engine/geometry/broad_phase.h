#pragma once

#include <utility>
#include <vector>

#include "engine/geometry/bvh.h"

namespace feder {

/// Which of many boxes overlap. A tree over the boxes is kept from one update to the next: refitted while it
/// is good, built anew when the boxes have moved apart. Answers depend on the boxes alone, not on what came
/// before.
class BroadPhase {
 public:
  /// Boxes [m], closed, of any size; without bound in some direction allowed (a few: each is compared with
  /// all), empty ones meet nothing. InputError: NaN.
  void update(const std::vector<Aabb>& boxes);

  /// Pairs (i, j), i < j, of boxes that overlap, sorted; touching counts.
  void find_pairs(std::vector<std::pair<int, int>>& out) const;
  /// Pairs (i, j) of a box i here and a box j of another set that overlap, sorted.
  void find_pairs(const BroadPhase& other, std::vector<std::pair<int, int>>& out) const;

  int size() const { return static_cast<int>(boxes_.size()); }

 private:
  void build();
  double refit();  // cost of the tree: sum of half the surfaces of its inner nodes over that of the root

  std::vector<Aabb> boxes_;
  std::vector<int> bounded_, unbounded_;  // ids of the boxes in the tree and of those beside it
  std::vector<BvhNode<Aabb>> nodes_;
  std::vector<int> order_;  // ids by position
  double built_cost_ = 0.0;
};

}  // namespace feder
