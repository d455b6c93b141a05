// Separating planes (notes A9) against exact integers and triangle distances.
#include "engine/geometry/separating_plane.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "engine/check.h"
#include "tests/engine/geometry/triangle_pairs.h"
#include "tests/support/campaign.h"
#include "tests/support/exact_hulls.h"

namespace feder {
namespace {

using Points = std::vector<Vector3d>;

Points corners(const Obb& box) {
  Points out;
  for (int i = 0; i < 8; ++i)
    out.push_back(box.centre +
                  box.axes * box.half.cwiseProduct(Vector3d(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  return out;
}

double size_of(const Points& a, const Points& b) {
  double size = 0.0;
  for (const Points* points : {&a, &b})
    for (const Vector3d& p : *points) size = std::max(size, (p - a[0]).norm());
  return size;
}

// normal . (x - point) < 0 for A, > 0 for B, in exact rationals
bool separates(const ConvexSeparation& found, const Points& a, const Points& b) {
  const auto height = [&](const Vector3d& x) {
    mpq_class sum = 0;
    for (int k = 0; k < 3; ++k)
      sum += mpq_class(found.normal[k]) * (mpq_class(x[k]) - mpq_class(found.point[k]));
    return sum;
  };
  for (const Vector3d& x : a)
    if (height(x) >= 0) return false;
  for (const Vector3d& x : b)
    if (height(x) <= 0) return false;
  return true;
}

struct PolytopePair {
  Points a, b;
};

PolytopePair random_polytopes(Random& random, int kind) {
  PolytopePair pair;
  if (kind == 0) {  // boxes, half of them degenerate
    const test::BoxPair boxes = test::random_box_pair(random);
    return {corners(boxes.a), corners(boxes.b)};
  }
  if (kind == 1) {  // triangles of every kind
    const auto triangle_kind =
        static_cast<test::TriangleCase>(random.below(static_cast<int>(test::TriangleCase::kCount)));
    const test::TrianglePair triangles = test::random_triangle_pair(random, triangle_kind);
    return {{triangles.a.begin(), triangles.a.end()}, {triangles.b.begin(), triangles.b.end()}};
  }
  // clouds, some with inner points, duplicates and points on edges
  const double apart = random.uniform(0.0, 2.0);
  for (Points* points : {&pair.a, &pair.b}) {
    const int count = 1 + random.below(20);
    for (int i = 0; i < count; ++i) points->push_back(random.vector());
    if (random.below(3) == 0) points->push_back(points->front());
    if (random.below(3) == 0) points->push_back(0.5 * (points->front() + points->back()));
  }
  for (Vector3d& p : pair.b) p[0] += apart;
  return pair;
}

TEST(SeparatingPlaneCampaign, EveryDisjointPairHasOneAndNoOtherHas) {
  constexpr std::uint64_t kSeed = 20130503;
  Random random(kSeed);
  const int cases = test::campaign_cases(100000);
  std::array<int, 3> overlapping{}, disjoint{};
  int in_band = 0, wrong = 0;
  double worst_gap = 0.0;
  for (int k = 0; k < cases; ++k) {
    const auto [a, b] = random_polytopes(random, k % 3);
    const double band = 1e-12 * size_of(a, b);
    test::BinaryScale scale;
    for (const Points* points : {&a, &b})
      for (const Vector3d& p : *points) scale.include(p);
    scale.include(band);
    const auto p = exact_points(scale, a), q = exact_points(scale, b);
    const bool exact = test::hulls_meet(p, q);
    ++(exact ? overlapping : disjoint)[k % 3];

    const ConvexSeparation found = separation(a, b), turned = separation(b, a);
    EXPECT_TRUE(std::isfinite(found.distance) && found.point_a.allFinite() && found.point_b.allFinite()) << k;
    EXPECT_TRUE(found.overlap == turned.overlap && found.distance == turned.distance &&
                found.normal == -turned.normal && found.point_a == turned.point_b)
        << "seed " << kSeed << ", case " << k;

    // the plane itself proves what it claims; the distance is what the plane sees
    if (!found.overlap && !exact) {
      const double last_bit = 2e-16 * found.point.cwiseAbs().maxCoeff();
      EXPECT_TRUE(separates(found, a, b) || found.distance < std::max(band, 2.0 * last_bit))
          << "seed " << kSeed << ", case " << k;
      double high = -INFINITY, low = INFINITY;
      for (const Vector3d& x : a) high = std::max(high, found.normal.dot(x - found.point));
      for (const Vector3d& x : b) low = std::min(low, found.normal.dot(x - found.point));
      worst_gap = std::max(worst_gap, std::abs(low - high - found.distance) / size_of(a, b));
    }
    if (found.overlap == exact) continue;
    const bool within = exact ? !test::hulls_meet(p, test::shifted(q, scale.whole(band * found.normal)))
                              : test::hulls_meet(p, test::grown(q, scale.whole(band)));
    ++(within ? in_band : wrong);
    EXPECT_TRUE(within) << "seed " << kSeed << ", case " << k << ": exactly " << exact << ", distance "
                        << found.distance;
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_LT(worst_gap, 1e-13);  // 2e-15; all: 4.4e-15
  for (int kind = 0; kind < 3; ++kind) {
    EXPECT_GT(overlapping[kind], cases / 20);
    EXPECT_GT(disjoint[kind], cases / 20);
  }
  std::printf(
      "%d pairs, %d inside the band, %d wrong, distance and plane differ by %.2g of the size; disjoint: %d "
      "%d %d\n",
      cases, in_band, wrong, worst_gap, disjoint[0], disjoint[1], disjoint[2]);
}

TEST(SeparatingPlane, DistanceOfTrianglesIsTheirs) {
  Random random(1);
  double worst = 0.0;
  for (int trial = 0; trial < 5000; ++trial) {
    const Triangle a = test::random_triangle(random), b = test::random_triangle(random);
    const ConvexSeparation found = separation(std::span<const Vector3d>(a), std::span<const Vector3d>(b));
    const TriangleSeparation expected = separation(a, b);
    EXPECT_EQ(found.overlap, expected.overlap);
    if (found.overlap) continue;
    worst = std::max({worst, std::abs(found.distance - expected.gap),
                      std::abs((found.point_b - found.point_a).norm() - expected.gap)});
  }
  EXPECT_LT(worst, 1e-13);  // 7e-16
}

TEST(SeparatingPlane, ClosestPointsLieInTheHulls) {
  Random random(2);
  double worst = 0.0;
  int overlapping = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    test::BoxPair pair = test::random_box_pair(random);
    const double size = pair.a.half.sum() + pair.b.half.sum() + (pair.b.centre - pair.a.centre).norm();
    const ConvexSeparation found = separation(corners(pair.a), corners(pair.b));
    overlapping += found.overlap;
    for (const auto& [box, point] : {std::pair{pair.a, found.point_a}, std::pair{pair.b, found.point_b}}) {
      const Vector3d local = box.axes.transpose() * (point - box.centre);
      worst = std::max(worst, (local.cwiseAbs() - box.half).maxCoeff() / size);
    }
    if (found.overlap) {
      EXPECT_EQ(found.distance, 0.0);
      EXPECT_EQ(found.normal, Vector3d::Zero());
    }
  }
  EXPECT_GT(overlapping, 500);
  EXPECT_LT(worst, 1e-9);  // 3e-11
}

TEST(SeparatingPlane, TouchingPolytopesHaveNone) {
  const Points a = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const Points face = {{0, 0, 0}, {-1, 0.5, 0.5}, {-1, 1, 0}}, corner = {{1, 0, 0}, {2, 1, 1}};
  EXPECT_TRUE(separation(a, face).overlap);
  EXPECT_TRUE(separation(a, corner).overlap);
  EXPECT_TRUE(separation(a, a).overlap);
  // closed half spaces admit it, strict ones do not: notes A9
  const Points beyond = {{1.0 + 1e-9, 0, 0}, {2, 1, 1}};
  EXPECT_FALSE(separation(a, beyond).overlap);
  EXPECT_NEAR(separation(a, beyond).distance, 1e-9, 1e-15);
}

TEST(SeparatingPlane, OfPointsIsHalfWayBetweenThem) {
  const Points a = {{1, 2, 3}}, b = {{1, 2, 5}};
  const ConvexSeparation found = separation(a, b);
  EXPECT_EQ(found.distance, 2.0);
  EXPECT_EQ(found.normal, Vector3d::UnitZ());
  EXPECT_EQ(found.point, Vector3d(1, 2, 4));
  EXPECT_TRUE(separation(a, a).overlap);
  EXPECT_THROW((void)separation(a, Points{}), MisuseError);
  EXPECT_THROW((void)separation(a, Points{{NAN, 0, 0}}), MisuseError);
}

}  // namespace
}  // namespace feder
