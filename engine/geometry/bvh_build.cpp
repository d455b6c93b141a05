// Surface area heuristic (Wald, On fast construction of SAH-based bounding volume hierarchies, 2007): items
// fall into bins by the centres of their boxes along the axis on which the centres spread most; the cut
// between two bins with the least  area(left) n(left) + area(right) n(right)  branches the tree.
#include "engine/geometry/bvh_build.h"

#include <algorithm>
#include <array>
#include <limits>

#include "engine/geometry/bvh.h"

namespace feder {
namespace {

constexpr int kBins = 16;
constexpr int kFew = 16;  // up to here the middle of the centres is cut, bins would cost more than they gain
constexpr int kMedianDepth = 48;  // from here on halves, so that the depth is bounded by 48 + 32
constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct Box {
  Eigen::Array4f min = Eigen::Array4f::Constant(kInfinity), max = Eigen::Array4f::Constant(-kInfinity);

  void add(const Eigen::Array4f& low, const Eigen::Array4f& high) {
    min = min.min(low);
    max = max.max(high);
  }
  float half_area() const {
    const Eigen::Array4f d = max - min;
    return d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
  }
  int longest() const {
    const Eigen::Array4f d = max - min;
    return d[0] >= d[1] && d[0] >= d[2] ? 0 : d[1] >= d[2] ? 1 : 2;
  }
};

// Twice the centre.
void add_centre(Box& box, const BuildItem& item) {
  const Eigen::Array4f centre = item.min + item.max;
  box.add(centre, centre);
}

struct Task {
  std::int32_t node, begin, end, depth;
  Box centres;
};

struct Bin {
  Box box;
  int count = 0;
};

// First bin of the right side of the best cut; 0: no cut divides the items.
int best_cut(const std::array<Bin, kBins>& bins) {
  std::array<float, kBins> right_cost;
  Box right;
  int count = 0;
  for (int k = kBins - 1; k > 0; --k) {
    right.add(bins[k].box.min, bins[k].box.max);
    count += bins[k].count;
    right_cost[k] = count ? static_cast<float>(count) * right.half_area() : kInfinity;
  }
  Box left;
  int cut = 0;
  float least = kInfinity;
  count = 0;
  for (int k = 1; k < kBins; ++k) {
    left.add(bins[k - 1].box.min, bins[k - 1].box.max);
    count += bins[k - 1].count;
    const float cost = count ? static_cast<float>(count) * left.half_area() + right_cost[k] : kInfinity;
    if (cost < least) least = cost, cut = k;
  }
  return cut;
}

// Halves by rank along the axis; the way out where no cut between bins is left.
std::int32_t cut_at_median(std::vector<BuildItem>& items, const Task& task, int axis) {
  const std::int32_t middle = task.begin + (task.end - task.begin) / 2;
  const auto before = [axis](const BuildItem& a, const BuildItem& b) {
    const float x = a.min[axis] + a.max[axis], y = b.min[axis] + b.max[axis];
    return x != y ? x < y : a.id() < b.id();
  };
  std::nth_element(items.begin() + task.begin, items.begin() + middle, items.begin() + task.end, before);
  return middle;
}

// Where the best of the cuts between bins lies along the axis; items left of it have twice their centre
// below.
float cut_between_bins(const std::vector<BuildItem>& items, const Task& task, int axis, float low,
                       float width) {
  const float scale = static_cast<float>(kBins) / width;
  std::array<Bin, kBins> bins;
  for (std::int32_t i = task.begin; i < task.end; ++i) {
    const float centre = items[i].min[axis] + items[i].max[axis];
    Bin& bin = bins[std::min(static_cast<int>((centre - low) * scale), kBins - 1)];
    bin.box.add(items[i].min, items[i].max);
    ++bin.count;
  }
  return low + static_cast<float>(best_cut(bins)) / scale;
}

// Sorts the items of the task into two sides and bounds the centres of each; the first item of the right
// side.
std::int32_t cut(std::vector<BuildItem>& items, const Task& task, Box& left, Box& right) {
  const int axis = task.centres.longest();
  const float low = task.centres.min[axis], width = task.centres.max[axis] - low;
  std::int32_t middle = task.begin;
  if (width > 0.0f && task.depth < kMedianDepth) {
    const bool few = task.end - task.begin <= kFew;
    const float border = few ? low + 0.5f * width : cut_between_bins(items, task, axis, low, width);
    std::int32_t end = task.end;
    while (middle < end) {
      if (items[middle].min[axis] + items[middle].max[axis] < border) {
        add_centre(left, items[middle++]);
      } else {
        std::swap(items[middle], items[--end]);
        add_centre(right, items[end]);
      }
    }
  }
  if (middle != task.begin && middle != task.end) return middle;
  middle = cut_at_median(items, task, axis);
  left = right = Box();
  for (std::int32_t i = task.begin; i < task.end; ++i) add_centre(i < middle ? left : right, items[i]);
  return middle;
}

// Coordinates to the unit cube: nothing overflows in single precision.
struct UnitCube {
  Vector3d origin;
  double scale;

  UnitCube(const Vector3d& low, const Vector3d& high) : origin(low) {
    const double size = (0.5 * high - 0.5 * low).maxCoeff();
    scale = size > std::numeric_limits<double>::min() ? 0.5 / size : 0.0;
  }
  BuildItem item(const Vector3d& low, const Vector3d& high, std::size_t id) const {
    BuildItem out;
    for (int c = 0; c < 3; ++c) {
      out.min[c] = static_cast<float>(scale * low[c] - scale * origin[c]);
      out.max[c] = static_cast<float>(scale * high[c] - scale * origin[c]);
    }
    out.min[3] = std::bit_cast<float>(static_cast<std::int32_t>(id));
    out.max[3] = 0.0f;
    return out;
  }
};

}  // namespace

std::vector<BuildItem> build_items(const std::vector<Aabb>& boxes) {
  std::vector<BuildItem> items;
  if (boxes.empty()) return items;
  Vector3d low = boxes[0].min, high = boxes[0].max;
  for (const Aabb& box : boxes) low = low.cwiseMin(box.min), high = high.cwiseMax(box.max);
  const UnitCube cube(low, high);
  items.reserve(boxes.size());
  for (const Aabb& box : boxes) items.push_back(cube.item(box.min, box.max, items.size()));
  return items;
}

std::vector<BuildItem> build_items(const TriangleMesh& mesh) {
  std::vector<BuildItem> items;
  if (mesh.triangles.empty()) return items;
  Vector3d low = mesh.vertices[mesh.triangles[0][0]], high = low;
  for (const Vector3d& x : mesh.vertices) low = low.cwiseMin(x), high = high.cwiseMax(x);
  const UnitCube cube(low, high);
  items.reserve(mesh.triangles.size());
  for (const auto& [i, j, k] : mesh.triangles) {
    const Vector3d &a = mesh.vertices[i], &b = mesh.vertices[j], &c = mesh.vertices[k];
    items.push_back(cube.item(a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c), items.size()));
  }
  return items;
}

std::vector<BvhLinks> build_branches(std::vector<BuildItem>& items, int leaf) {
  std::vector<BvhLinks> nodes;
  if (items.empty()) return nodes;
  nodes.reserve(2 * items.size());
  nodes.push_back({0, 0});
  std::vector<Task> tasks{{0, 0, static_cast<std::int32_t>(items.size()), 0, {}}};
  for (const BuildItem& item : items) add_centre(tasks[0].centres, item);
  while (!tasks.empty()) {
    const Task task = tasks.back();
    tasks.pop_back();
    if (task.end - task.begin <= leaf) {
      nodes[task.node] = {task.begin, task.end - task.begin};
      continue;
    }
    Box left, right;
    const std::int32_t middle = cut(items, task, left, right);
    const std::int32_t child = static_cast<std::int32_t>(nodes.size());
    nodes[task.node] = {child, 0};
    nodes.resize(nodes.size() + 2);
    tasks.push_back({child + 1, middle, task.end, task.depth + 1, right});
    tasks.push_back({child, task.begin, middle, task.depth + 1, left});
  }
  return nodes;
}

}  // namespace feder
