#include "engine/geometry/bvh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <set>

#include "engine/check.h"
#include "engine/geometry/bvh_queries.h"
#include "engine/geometry/bvh_traversal.h"
#include "tests/engine/geometry/random_mesh.h"
#include "tests/support/campaign.h"

namespace feder {
namespace {

using test::corners_of;

std::vector<TrianglePair> all_pairs(const TriangleMesh& a, const Pose& pose_a, const TriangleMesh& b,
                                    const Pose& pose_b) {
  const Relative frame = relative(pose_a, pose_b, 0.0);
  std::vector<TrianglePair> out;
  for (int i = 0; i < static_cast<int>(a.triangles.size()); ++i)
    for (int j = 0; j < static_cast<int>(b.triangles.size()); ++j)
      if (overlap(corners_of(a, i), frame(corners_of(b, j)))) out.emplace_back(i, j);
  return out;
}

struct MeshPair {
  TriangleMesh a, b;
  Pose pose_a, pose_b;
};
MeshPair random_pair(Random& random) {
  MeshPair pair;
  pair.a = test::random_soup(random, test::random_count(random), random.uniform(0.05, 0.5));
  pair.b = test::random_soup(random, test::random_count(random), random.uniform(0.05, 0.5));
  pair.pose_a = test::random_pose(random, 3.0);
  pair.pose_b = pair.pose_a;
  if (random.below(4) > 0) pair.pose_b.rotation = test::random_pose(random, 1.0).rotation;
  pair.pose_b.position += random.vector(1.5);
  return pair;
}

std::vector<TrianglePair> swapped(std::vector<TrianglePair> pairs) {
  for (auto& [i, j] : pairs) std::swap(i, j);
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

// First hit, all pairs, both orders of the arguments; the number of pairs.
template <class Volume>
std::size_t expect_all_pairs(const Bvh<Volume>& a, const Bvh<Volume>& b, const MeshPair& m) {
  const std::vector<TrianglePair> expected = all_pairs(m.a, m.pose_a, m.b, m.pose_b);
  const std::vector<TrianglePair> found = all_overlaps(a, m.pose_a, b, m.pose_b);
  EXPECT_EQ(found, expected);
  EXPECT_EQ(swapped(all_overlaps(b, m.pose_b, a, m.pose_a)), expected);
  const std::optional<TrianglePair> first = any_overlap(a, m.pose_a, b, m.pose_b);
  EXPECT_EQ(first.has_value(), !expected.empty());
  if (first) EXPECT_TRUE(std::binary_search(expected.begin(), expected.end(), *first));
  return expected.size();
}

template <class Volume>
class BvhCampaign : public testing::Test {};
using Volumes = testing::Types<Sphere, Aabb, Obb>;
TYPED_TEST_SUITE(BvhCampaign, Volumes);

// Full campaign: 1000 pairs of 1 to 512 triangles, and again after every vertex has moved.
TYPED_TEST(BvhCampaign, OverlapsAreThoseOfAllPairsAlsoAfterRefit) {
  int meeting = 0;
  for (int seed = 0; seed < test::campaign_cases(1000); ++seed) {
    SCOPED_TRACE(seed);
    Random random(static_cast<std::uint64_t>(seed));
    MeshPair m = random_pair(random);
    Bvh<TypeParam> a(m.a), b(m.b);
    meeting += expect_all_pairs(a, b, m) > 0;
    for (Vector3d& x : m.a.vertices) x += random.vector(0.3);
    for (Vector3d& x : m.b.vertices) x = 1.5 * x + random.vector(0.1);
    a.refit(m.a.vertices);
    b.refit(m.b.vertices);
    expect_all_pairs(a, b, m);
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_GT(meeting, test::campaign_cases(1000) / 4);  // the question is not empty
}

TYPED_TEST(BvhCampaign, ClosestPointsOfMeshesAreThoseOfAllPairs) {
  for (int seed = 0; seed < test::campaign_cases(1000); ++seed) {
    SCOPED_TRACE(seed);
    Random random(static_cast<std::uint64_t>(seed));
    MeshPair m = random_pair(random);
    m.pose_b.position += random.vector(3.0);
    const Relative frame = relative(m.pose_a, m.pose_b, 0.0);
    double expected = std::numeric_limits<double>::infinity();
    for (int i = 0; i < static_cast<int>(m.a.triangles.size()); ++i)
      for (int j = 0; j < static_cast<int>(m.b.triangles.size()); ++j)
        expected = std::min(expected,
                            closest_points(corners_of(m.a, i), frame(corners_of(m.b, j))).distance_squared);
    const auto found = closest_points(Bvh<TypeParam>(m.a), m.pose_a, Bvh<TypeParam>(m.b), m.pose_b);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->distance, std::sqrt(expected));
    EXPECT_NEAR((found->a - found->b).norm(), found->distance, 1e-13);
    if (testing::Test::HasFailure()) return;
  }
}

TYPED_TEST(BvhCampaign, ClosestPointAndFirstHitAreThoseOfAllTriangles) {
  int hits = 0;
  for (int seed = 0; seed < test::campaign_cases(1000); ++seed) {
    SCOPED_TRACE(seed);
    Random random(static_cast<std::uint64_t>(seed));
    const TriangleMesh mesh = test::random_soup(random, test::random_count(random), 0.3);
    const Bvh<TypeParam> hierarchy(mesh);
    const Vector3d p = random.vector(2.0), direction = random.vector(0.5) - p;
    double nearest = std::numeric_limits<double>::infinity(), first = 2.0;
    bool hit = false;
    for (int k = 0; k < static_cast<int>(mesh.triangles.size()); ++k) {
      nearest = std::min(nearest, closest_point(corners_of(mesh, k), p).distance_squared);
      if (const auto t = ray_hit(corners_of(mesh, k), p, direction, first)) first = *t, hit = true;
    }
    const auto point = closest_point(hierarchy, p, 10.0);
    ASSERT_TRUE(point);
    EXPECT_EQ(point->distance_squared, nearest);
    EXPECT_FALSE(closest_point(hierarchy, p, 0.999 * std::sqrt(nearest)));
    const auto found = first_hit(hierarchy, p, direction, 2.0);
    EXPECT_EQ(found.has_value(), hit);
    if (found && hit) EXPECT_EQ(found->t, first);
    hits += hit;
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_GT(hits, test::campaign_cases(1000) / 20);
}

TYPED_TEST(BvhCampaign, SelfOverlapsAreThoseOfAllPairsWithoutACommonVertex) {
  for (int seed = 0; seed < test::campaign_cases(1000); ++seed) {
    SCOPED_TRACE(seed);
    Random random(static_cast<std::uint64_t>(seed));
    TriangleMesh mesh = test::random_soup(random, test::random_count(random), 0.2);
    Bvh<TypeParam> hierarchy(mesh);
    for (Vector3d& x : mesh.vertices) x += random.vector(0.3);
    hierarchy.refit(mesh.vertices);
    std::vector<TrianglePair> expected;
    for (int i = 0; i < hierarchy.size(); ++i)
      for (int j = i + 1; j < hierarchy.size(); ++j) {
        const std::set<int> s(mesh.triangles[i].begin(), mesh.triangles[i].end());
        const auto& t = mesh.triangles[j];
        if (s.count(t[0]) + s.count(t[1]) + s.count(t[2]) == 0 &&
            overlap(corners_of(mesh, i), corners_of(mesh, j)))
          expected.emplace_back(i, j);
      }
    EXPECT_EQ(self_overlaps(hierarchy), expected);
    if (testing::Test::HasFailure()) return;
  }
}

template <class Volume>
class BvhOf : public testing::Test {};
TYPED_TEST_SUITE(BvhOf, Volumes);

TYPED_TEST(BvhOf, NothingMeetsNothing) {
  const Bvh<TypeParam> none(TriangleMesh{}),
      one(TriangleMesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}});
  EXPECT_FALSE(any_overlap(none, {}, one, {}));
  EXPECT_FALSE(closest_points(one, {}, none, {}));
  EXPECT_FALSE(closest_point(none, {0, 0, 0}, 1.0));
  EXPECT_FALSE(first_hit(none, {0, 0, 0}, {1, 0, 0}, 1.0));
  EXPECT_TRUE(self_overlaps(none).empty());
}

// Every position once; children after their parent; no path longer than promised, even where all triangles
// are the same.
TYPED_TEST(BvhOf, IsATreeOverAllTriangles) {
  TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {}};
  mesh.triangles.assign(5000, {0, 1, 2});
  for (int k = 0; k < 2000; ++k) {  // a geometric sequence: every cut leaves all but a few on one side
    const double x = std::ldexp(1.0, -k / 2);
    mesh.vertices.emplace_back(x, 0, 0);
    mesh.triangles.push_back({0, 1, k + 3});
  }
  const Bvh<TypeParam> hierarchy(mesh);
  const auto& nodes = hierarchy.nodes();
  std::vector<int> depth(nodes.size(), 0), seen(mesh.triangles.size(), 0);
  depth[0] = 1;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    EXPECT_GT(depth[k], 0);
    EXPECT_LE(depth[k], kBvhDepth);
    for (int i = 0; i < nodes[k].count; ++i) ++seen[hierarchy.triangle(nodes[k].first + i)];
    if (nodes[k].count == 0) {
      ASSERT_GT(nodes[k].first, static_cast<int>(k));
      depth[nodes[k].first] = depth[nodes[k].first + 1] = depth[k] + 1;
    }
    EXPECT_LE(nodes[k].count, kBvhLeaf);
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), 7000);
}

// Notes A18 as printed: both children of both nodes, else nothing.
template <class Volume>
bool printed_traversal_meets(const Bvh<Volume>& a, const Bvh<Volume>& b) {
  const Relative frame = relative({}, {}, 0.0);
  std::vector<std::pair<int, int>> stack{{0, 0}};
  while (!stack.empty()) {
    const auto [i, j] = stack.back();
    stack.pop_back();
    const BvhNode<Volume>&x = a.nodes()[i], &y = b.nodes()[j];
    if (apart(x.volume, y.volume, frame)) continue;
    if (x.count > 0 && y.count > 0) {
      for (int k = x.first; k < x.first + x.count; ++k)
        for (int l = y.first; l < y.first + y.count; ++l)
          if (overlap(a.corners(k), b.corners(l))) return true;
    } else if (x.count == 0 && y.count == 0) {
      for (int k = 0; k < 2; ++k)
        for (int l = 0; l < 2; ++l) stack.emplace_back(x.first + k, y.first + l);
    }
  }
  return false;
}

TYPED_TEST(BvhOf, DescendsTheInnerNodeBesideALeafUnlikeThePrintedTraversal) {
  Random random(1);
  const TriangleMesh many = test::random_soup(random, 100, 0.3);
  const Bvh<TypeParam> tree(many),
      leaf(TriangleMesh{{corners_of(many, 7)[0], {5, 0, 0}, {5, 1, 0}}, {{0, 1, 2}}});
  EXPECT_TRUE(any_overlap(tree, {}, leaf, {}));
  EXPECT_TRUE(any_overlap(leaf, {}, tree, {}));
  EXPECT_FALSE(printed_traversal_meets(tree, leaf));
  EXPECT_FALSE(printed_traversal_meets(leaf, tree));
}

TYPED_TEST(BvhOf, RefusesWhatIsNoPlaceOrNoVertex) {
  TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  Bvh<TypeParam> hierarchy(mesh);
  EXPECT_THROW(hierarchy.refit({{0, 0, 0}, {1, 0, 0}}), MisuseError);
  mesh.vertices[1].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(hierarchy.refit(mesh.vertices), InputError);
  EXPECT_THROW(Bvh<TypeParam>{mesh}, InputError);
  EXPECT_THROW((Bvh<TypeParam>{TriangleMesh{{{0, 0, 0}}, {{0, 0, 1}}}}), InputError);
}

}  // namespace
}  // namespace feder
