// Triangle overlap (notes A12) against exact integers.
#include "engine/geometry/triangle_overlap.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "tests/engine/geometry/triangle_pairs.h"
#include "tests/support/campaign.h"
#include "tests/support/exact_hulls.h"

namespace feder {
namespace {

using test::TriangleCase;
using test::TrianglePair;

constexpr double kBand = 1e-12;

double band(const TrianglePair& pair) {
  double size = 0.0;
  for (const Vector3d& p : pair.a)
    for (const Vector3d& q : pair.b)
      size = std::max({size, (p - q).norm(), (p - pair.a[0]).norm(), (q - pair.b[0]).norm()});
  return kBand * size;
}

TEST(TriangleCampaign, EveryAnswerOutsideTheBandIsThatOfExactArithmetic) {
  constexpr std::uint64_t kSeed = 20130502;
  Random random(kSeed);
  const int cases = test::campaign_cases(100000);
  constexpr int kKinds = static_cast<int>(TriangleCase::kCount);
  int in_band = 0, wrong = 0;
  std::array<int, kKinds> count{}, overlapping{};
  for (int k = 0; k < cases; ++k) {
    const int kind = k % kKinds;
    const TrianglePair pair = test::random_triangle_pair(random, static_cast<TriangleCase>(kind));
    const double width = band(pair);
    test::BinaryScale scale;
    for (const Triangle* t : {&pair.a, &pair.b})
      for (const Vector3d& p : *t) scale.include(p);
    scale.include(width);
    const auto a = exact_points(scale, pair.a), b = exact_points(scale, pair.b);
    const bool exact = test::hulls_meet(a, b);
    ++count[kind];
    overlapping[kind] += exact;

    // symmetric to the last bit, finite, unit
    const bool fast = overlap(pair.a, pair.b);
    const TriangleSeparation full = separation(pair.a, pair.b), turned = separation(pair.b, pair.a);
    const bool symmetric =
        fast == overlap(pair.b, pair.a) && full.gap == turned.gap && full.overlap == turned.overlap;
    const bool sound = std::isfinite(full.gap) && std::abs(full.axis.norm() - 1.0) < 1e-14;
    if (!symmetric || !sound)
      ADD_FAILURE() << "seed " << kSeed << ", case " << k << (symmetric ? ": not finite" : ": not symmetric");
    if (fast == exact && full.overlap == exact) continue;

    const bool within = exact ? !test::hulls_meet(a, test::shifted(b, scale.whole(width * full.axis)))
                              : test::hulls_meet(a, test::grown(b, scale.whole(width)));
    ++(within ? in_band : wrong);
    if (!within)
      ADD_FAILURE() << "seed " << kSeed << ", case " << k << ", kind " << kind << ": exactly " << exact
                    << ", fast " << fast << ", gap " << full.gap;
  }
  EXPECT_EQ(wrong, 0);
  std::printf("%d pairs, %d inside the band, %d wrong; overlapping per kind:", cases, in_band, wrong);
  for (int kind = 0; kind < kKinds; ++kind) {
    std::printf(" %d/%d", overlapping[kind], count[kind]);
    EXPECT_GT(overlapping[kind], 0) << "kind " << kind;
    const auto named = static_cast<TriangleCase>(kind);
    if (named != TriangleCase::kPiercing && named != TriangleCase::kSharedVertex &&
        named != TriangleCase::kSharedEdge) {
      EXPECT_LT(overlapping[kind], count[kind]) << "kind " << kind;
    }
  }
  std::printf("\n");
}

// Distance of a point from a triangle, by the seven features in barycentric coordinates.
double point_distance(const Vector3d& p, const Triangle& t) {
  const auto to_segment = [&](const Vector3d& a, const Vector3d& b) {
    const double s = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
    return (p - (a + s * (b - a))).norm();
  };
  const double edges = std::min({to_segment(t[0], t[1]), to_segment(t[1], t[2]), to_segment(t[2], t[0])});
  const Vector3d n = (t[1] - t[0]).cross(t[2] - t[0]);
  for (int k = 0; k < 3; ++k)
    if (n.cross(t[(k + 1) % 3] - t[k]).dot(p - t[k]) < 0.0) return edges;
  return std::abs(n.dot(p - t[0])) / n.norm();
}

// Closest points of two lines, if inside both segments; the ends are someone else's business.
double line_distance(const Vector3d& p, const Vector3d& d, const Vector3d& q, const Vector3d& e) {
  const double dd = d.dot(d), de = d.dot(e), ee = e.dot(e), det = dd * ee - de * de;
  const Vector3d r = q - p;
  const double s = (r.dot(d) * ee - r.dot(e) * de) / det, t = (r.dot(d) * de - r.dot(e) * dd) / det;
  return s >= 0 && s <= 1 && t >= 0 && t <= 1 ? (p + s * d - q - t * e).norm() : INFINITY;
}

TEST(Triangle, GapOfDisjointTrianglesIsTheirDistance) {
  Random random(1);
  double worst = 0.0;
  int disjoint = 0;
  for (int trial = 0; trial < 5000; ++trial) {
    const Triangle a = test::random_triangle(random), b = test::random_triangle(random);
    const TriangleSeparation found = separation(a, b);
    if (found.overlap) continue;
    ++disjoint;
    double expected = INFINITY;
    for (int i = 0; i < 3; ++i) {
      expected = std::min({expected, point_distance(a[i], b), point_distance(b[i], a)});
      for (int j = 0; j < 3; ++j)
        expected =
            std::min(expected, line_distance(a[i], a[(i + 1) % 3] - a[i], b[j], b[(j + 1) % 3] - b[j]));
    }
    worst = std::max(worst, std::abs(found.gap - expected));
  }
  EXPECT_GT(disjoint, 3000);
  EXPECT_LT(worst, 1e-13);  // 1.2e-15
}

TEST(Triangle, DepthAlongTheAxisIsWhatPartsThem) {
  Random random(2);
  int overlapping = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const Triangle a = test::random_triangle(random);
    const Triangle b = test::random_triangle(random);
    const TriangleSeparation found = separation(a, b);
    if (!found.overlap) continue;
    ++overlapping;
    const auto moved_overlaps = [&](const Vector3d& shift) {
      return overlap(a, {b[0] + shift, b[1] + shift, b[2] + shift});
    };
    EXPECT_FALSE(moved_overlaps((-found.gap + 1e-9) * found.axis));
    for (int other = 0; other < 20; ++other)
      EXPECT_TRUE(moved_overlaps((-found.gap - 1e-9) * random.vector().normalized()));
  }
  EXPECT_GT(overlapping, 500);
}

TEST(Triangle, InOnePlaneNeedsTheInPlaneAxes) {
  // side by side in z = 0: both normals and all nine cross products are along z and see one interval
  const Triangle a{Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(0, 1, 0)};
  const Triangle b{Vector3d(1, 1, 0), Vector3d(1, 0.1, 0), Vector3d(0.1, 1, 0)};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const Vector3d v = (a[(i + 1) % 3] - a[i]).cross(b[(j + 1) % 3] - b[j]);
      for (const Vector3d& p : a) EXPECT_EQ(v.dot(p), 0.0);
      for (const Vector3d& p : b) EXPECT_EQ(v.dot(p), 0.0);
    }
  EXPECT_FALSE(overlap(a, b));
  EXPECT_NEAR(separation(a, b).gap, 0.1 / std::sqrt(2.0), 1e-15);  // 0
  const Triangle nested{Vector3d(0.1, 0.1, 0), Vector3d(0.2, 0.1, 0), Vector3d(0.1, 0.2, 0)};
  EXPECT_TRUE(overlap(a, nested));
}

TEST(Triangle, NeedlesTipToTipAreSeparatedByTheirTips) {
  // along one line, 1e-9 apart, 1e-8 thick: the in-plane axes n x e see a gap of 1e-17
  const double width = 1e-8;
  const Triangle a{Vector3d(-1, width, 0), Vector3d(-1, -width, 0), Vector3d(0, 0, 0)};
  for (double apart : {1e-9, 1e-11}) {
    const Triangle b{Vector3d(1, width, 0), Vector3d(1, -width, 0), Vector3d(apart, 0, 0)};
    EXPECT_FALSE(overlap(a, b));
    EXPECT_NEAR(separation(a, b).gap, apart, 1e-15);  // 9e-16
    EXPECT_LT((separation(a, b).axis - Vector3d::UnitX()).norm(), 1e-15);
  }
}

TEST(Triangle, TouchingCountsAsOverlap) {
  const Triangle a{Vector3d(0, 0, 0), Vector3d(2, 0, 0), Vector3d(0, 2, 0)};
  const auto touches = [&](const Vector3d& p, const Vector3d& q, const Vector3d& r) {
    return overlap(a, {p, q, r}) && overlap({p, q, r}, a);
  };
  EXPECT_TRUE(touches({0.5, 0.5, 0}, {0.5, 0.5, 1}, {1, 0.5, 1}));    // corner on face
  EXPECT_TRUE(touches({1, 0, 0}, {1, -1, 1}, {2, -1, 1}));            // corner on edge
  EXPECT_TRUE(touches({2, 0, 0}, {3, 0, 1}, {3, 1, 1}));              // corner on corner
  EXPECT_TRUE(touches({0, 0, 0}, {2, 0, 0}, {0, -2, 0}));             // common edge in one plane
  EXPECT_TRUE(touches({1, -1, -1}, {1, 1, 1}, {1, -1, 1}));           // edge on edge
  EXPECT_TRUE(touches({0.5, 0.5, 0}, {0.5, 0.5, 0}, {0.5, 0.5, 0}));  // a point
  EXPECT_FALSE(touches({0.5, 0.5, 1e-9}, {0.5, 0.5, 1}, {1, 0.5, 1}));
}

TEST(Triangle, OfSizesWhoseProductsOverflowOrVanishIsStillJudged) {
  for (double scale : {1e-150, 1e-110, 1e110, 1e150}) {
    const Triangle a{Vector3d(0, 0, 0), Vector3d(scale, 0, 0), Vector3d(0, scale, 0)};
    for (double height : {-0.1, 0.1}) {
      const Triangle b{scale * Vector3d(0.2, 0.2, height), scale * Vector3d(0.2, 0.2, 1),
                       scale * Vector3d(0.3, 0.2, 1)};
      EXPECT_EQ(overlap(a, b), height < 0.0) << scale;
      EXPECT_NEAR(separation(a, b).gap / scale, height, 1e-15) << scale;
    }
  }
}

}  // namespace
}  // namespace feder
