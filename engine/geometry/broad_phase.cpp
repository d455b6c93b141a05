// Bounding volume hierarchy over the boxes; two boxes overlap where they do on every axis. A tree whose cost
// by the surface area heuristic, sum over inner nodes of area/area(root), has grown by half since it was
// built is built anew.
#include "engine/geometry/broad_phase.h"

#include <algorithm>
#include <string>

#include "engine/check.h"
#include "engine/geometry/aabb.h"
#include "engine/geometry/bvh_build.h"
#include "engine/geometry/bvh_traversal.h"

namespace feder {
namespace {

constexpr int kLeaf = 4;          // boxes in a leaf, at most
constexpr double kWornOut = 1.5;  // growth of the cost at which a new tree pays

bool boxes_apart(const Aabb& a, const Aabb& b) {
  return !overlap(a, b);
}
double half_area(const Aabb& box) {
  const Vector3d d = box.max - box.min;
  return d.x() * d.y() + d.y() * d.z() + d.z() * d.x();
}

void check_numbers(const std::vector<Aabb>& boxes) {
  for (std::size_t k = 0; k < boxes.size(); ++k) {
    if (!boxes[k].min.hasNaN() && !boxes[k].max.hasNaN()) continue;
    const Vector3d& bad = boxes[k].min.hasNaN() ? boxes[k].min : boxes[k].max;
    for (double x : bad)
      if (std::isnan(x)) fail_input("broad phase, box " + std::to_string(k), "bound", x, "m", "a number");
  }
}

}  // namespace

void BroadPhase::update(const std::vector<Aabb>& boxes) {
  check_numbers(boxes);
  boxes_ = boxes;
  std::vector<int> bounded;
  bounded.reserve(boxes.size());
  unbounded_.clear();
  for (std::size_t k = 0; k < boxes.size(); ++k) {
    if (is_empty(boxes[k])) continue;
    const bool finite = boxes[k].min.allFinite() && boxes[k].max.allFinite();
    (finite ? bounded : unbounded_).push_back(static_cast<int>(k));
  }
  const bool same = bounded == bounded_;
  bounded_.swap(bounded);
  if (!same || refit() > kWornOut * built_cost_) build();
}

void BroadPhase::build() {
  std::vector<Aabb> boxes;
  boxes.reserve(bounded_.size());
  for (int id : bounded_) boxes.push_back(boxes_[id]);
  std::vector<BuildItem> items = build_items(boxes);
  const std::vector<BvhLinks> branches = build_branches(items, kLeaf);
  nodes_.resize(branches.size());
  for (std::size_t k = 0; k < nodes_.size(); ++k)
    nodes_[k].first = branches[k].first, nodes_[k].count = branches[k].count;
  order_.clear();
  for (const BuildItem& item : items) order_.push_back(bounded_[item.id()]);
  built_cost_ = refit();
}

double BroadPhase::refit() {
  double cost = 0.0;
  for (std::size_t k = nodes_.size(); k-- > 0;) {
    BvhNode<Aabb>& node = nodes_[k];
    if (node.count > 0) {
      node.volume = boxes_[order_[node.first]];
      for (int i = node.first + 1; i < node.first + node.count; ++i)
        node.volume = merged(node.volume, boxes_[order_[i]]);
    } else {
      node.volume = merged(nodes_[node.first].volume, nodes_[node.first + 1].volume);
      cost += half_area(node.volume);
    }
  }
  const double root = nodes_.empty() ? 0.0 : half_area(nodes_[0].volume);
  return root > 0.0 ? cost / root : 0.0;
}

void BroadPhase::find_pairs(std::vector<std::pair<int, int>>& out) const {
  out.clear();
  visit_leaf_pairs(nodes_, boxes_apart, [&](const BvhNode<Aabb>& x, const BvhNode<Aabb>& y) {
    for (int i = x.first; i < x.first + x.count; ++i)
      for (int j = &x == &y ? i + 1 : y.first; j < y.first + y.count; ++j)
        if (overlap(boxes_[order_[i]], boxes_[order_[j]])) out.push_back(std::minmax(order_[i], order_[j]));
    return false;
  });
  for (std::size_t k = 0; k < unbounded_.size(); ++k) {
    const int i = unbounded_[k];
    for (int j : bounded_)
      if (overlap(boxes_[i], boxes_[j])) out.push_back(std::minmax(i, j));
    for (std::size_t l = k + 1; l < unbounded_.size(); ++l)
      if (overlap(boxes_[i], boxes_[unbounded_[l]])) out.emplace_back(i, unbounded_[l]);
  }
  std::sort(out.begin(), out.end());
}

void BroadPhase::find_pairs(const BroadPhase& other, std::vector<std::pair<int, int>>& out) const {
  out.clear();
  const auto compare = [&](int i, int j) {
    if (overlap(boxes_[i], other.boxes_[j])) out.emplace_back(i, j);
  };
  if (!nodes_.empty() && !other.nodes_.empty())
    visit_leaf_pairs(nodes_, 0, other.nodes_, 0, boxes_apart,
                     [&](const BvhNode<Aabb>& x, const BvhNode<Aabb>& y) {
                       for (int i = x.first; i < x.first + x.count; ++i)
                         for (int j = y.first; j < y.first + y.count; ++j)
                           compare(order_[i], other.order_[j]);
                       return false;
                     });
  for (int i : unbounded_) {
    for (int j : other.bounded_) compare(i, j);
    for (int j : other.unbounded_) compare(i, j);
  }
  for (int j : other.unbounded_)
    for (int i : bounded_) compare(i, j);
  std::sort(out.begin(), out.end());
}

}  // namespace feder
