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

Aabb bounds_of(const Triangle& t) {
  return {t[0].cwiseMin(t[1]).cwiseMin(t[2]), t[0].cwiseMax(t[1]).cwiseMax(t[2])};
}
Aabb bounds_of(const Aabb& box) {
  return box;
}
Aabb bounds_of(const Sphere& ball) {
  return inflated({ball.centre, ball.centre}, ball.radius);
}
Aabb bounds_of(const Obb& box) {
  const Vector3d half = box.axes.cwiseAbs() * box.half;
  return {box.centre - half, box.centre + half};
}

// Triangles of a leaf of b that may meet a leaf of a, in the frame of a.
struct Candidates {
  std::array<Triangle, kBvhLeaf> corners;
  std::array<Aabb, kBvhLeaf> boxes;
  std::array<int, kBvhLeaf> positions;
  int count = 0;
  Aabb bounds = empty_aabb();

  void add(const Triangle& triangle, const Aabb& box, int position) {
    corners[count] = triangle;
    boxes[count] = box;
    positions[count++] = position;
    bounds = merged(bounds, box);
  }
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
    const Aabb reach = inflated(bounds_of(x.volume), frame.slack);
    Candidates others;
    for (int j = y.first; j < y.first + y.count; ++j) {
      const Triangle other = frame(b.corners(j));
      const Aabb box = bounds_of(other);
      if (overlap(reach, box)) others.add(other, box, j);
    }
    for (int i = x.first; others.count > 0 && i < x.first + x.count; ++i) {
      const Triangle triangle = a.corners(i);
      const Aabb box = inflated(bounds_of(triangle), frame.slack);
      if (!overlap(box, others.bounds)) continue;
      for (int k = 0; k < others.count; ++k)
        if (overlap(box, others.boxes[k]) && overlap(triangle, others.corners[k]) &&
            found(a.triangle(i), b.triangle(others.positions[k])))
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
