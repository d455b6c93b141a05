// Pairs of triangles that meet: leaves of the pair traversal, each tested in the frame of the first mesh.
#include <algorithm>

#include "engine/geometry/aabb.h"
#include "engine/geometry/bvh_queries.h"
#include "engine/geometry/bvh_traversal.h"
#include "engine/geometry/triangle_overlap.h"

namespace feder {
namespace {

Aabb inflated(const Aabb& box, double by) {
  return {box.min.array() - by, box.max.array() + by};
}

// Boxes of the few triangles of a leaf, so that most pairs are parted by six comparisons.
struct LeafTriangles {
  std::array<Triangle, kBvhLeaf> corners;
  std::array<Aabb, kBvhLeaf> boxes;
};

// Calls found(i, j) for the pairs of triangles that meet, until it says true.
template <class Volume, class Found>
void visit_overlaps(const Bvh<Volume>& a, const Pose& pose_a, const Bvh<Volume>& b, const Pose& pose_b,
                    Found&& found) {
  if (a.size() == 0 || b.size() == 0) return;
  const Relative frame =
      relative(pose_a, pose_b, reach_of(a.nodes()[0].volume) + reach_of(b.nodes()[0].volume));
  const auto apart_in_frame = [&frame](const Volume& x, const Volume& y) { return apart(x, y, frame); };
  const auto test = [&](const BvhNode<Volume>& x, const BvhNode<Volume>& y) {
    LeafTriangles left;
    for (int i = 0; i < x.count; ++i) {
      left.corners[i] = a.corners(x.first + i);
      left.boxes[i] = inflated(fit_aabb(left.corners[i]), frame.slack);
    }
    for (int j = y.first; j < y.first + y.count; ++j) {
      const Triangle other = frame(b.corners(j));
      const Aabb box = fit_aabb(other);
      for (int i = 0; i < x.count; ++i)
        if (overlap(left.boxes[i], box) && overlap(left.corners[i], other) &&
            found(a.triangle(x.first + i), b.triangle(j)))
          return true;
    }
    return false;
  };
  visit_leaf_pairs(a.nodes(), 0, b.nodes(), 0, apart_in_frame, test);
}

bool share_a_vertex(const std::array<int, 3>& s, const std::array<int, 3>& t) {
  return std::find_first_of(s.begin(), s.end(), t.begin(), t.end()) != s.end();
}

}  // namespace

template <class Volume>
std::optional<TrianglePair> any_overlap(const Bvh<Volume>& a, const Pose& pose_a, const Bvh<Volume>& b,
                                        const Pose& pose_b) {
  std::optional<TrianglePair> first;
  visit_overlaps(a, pose_a, b, pose_b, [&](int i, int j) {
    first = {i, j};
    return true;
  });
  return first;
}

template <class Volume>
std::vector<TrianglePair> all_overlaps(const Bvh<Volume>& a, const Pose& pose_a, const Bvh<Volume>& b,
                                       const Pose& pose_b) {
  std::vector<TrianglePair> pairs;
  visit_overlaps(a, pose_a, b, pose_b, [&](int i, int j) {
    pairs.emplace_back(i, j);
    return false;
  });
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

template <class Volume>
std::vector<TrianglePair> self_overlaps(const Bvh<Volume>& mesh) {
  std::vector<TrianglePair> pairs;
  if (mesh.size() == 0) return pairs;
  const Relative frame = relative({}, {}, reach_of(mesh.nodes()[0].volume));
  const auto apart_in_frame = [&frame](const Volume& x, const Volume& y) { return apart(x, y, frame); };
  visit_leaf_pairs(mesh.nodes(), apart_in_frame, [&](const BvhNode<Volume>& x, const BvhNode<Volume>& y) {
    for (int i = x.first; i < x.first + x.count; ++i)
      for (int j = &x == &y ? i + 1 : y.first; j < y.first + y.count; ++j)
        if (!share_a_vertex(mesh.indices(i), mesh.indices(j)) && overlap(mesh.corners(i), mesh.corners(j)))
          pairs.push_back(std::minmax(mesh.triangle(i), mesh.triangle(j)));
    return false;
  });
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

template std::optional<TrianglePair> any_overlap(const Bvh<Sphere>&, const Pose&, const Bvh<Sphere>&,
                                                 const Pose&);
template std::optional<TrianglePair> any_overlap(const Bvh<Aabb>&, const Pose&, const Bvh<Aabb>&,
                                                 const Pose&);
template std::optional<TrianglePair> any_overlap(const Bvh<Obb>&, const Pose&, const Bvh<Obb>&, const Pose&);
template std::vector<TrianglePair> all_overlaps(const Bvh<Sphere>&, const Pose&, const Bvh<Sphere>&,
                                                const Pose&);
template std::vector<TrianglePair> all_overlaps(const Bvh<Aabb>&, const Pose&, const Bvh<Aabb>&, const Pose&);
template std::vector<TrianglePair> all_overlaps(const Bvh<Obb>&, const Pose&, const Bvh<Obb>&, const Pose&);
template std::vector<TrianglePair> self_overlaps(const Bvh<Sphere>&);
template std::vector<TrianglePair> self_overlaps(const Bvh<Aabb>&);
template std::vector<TrianglePair> self_overlaps(const Bvh<Obb>&);

}  // namespace feder
