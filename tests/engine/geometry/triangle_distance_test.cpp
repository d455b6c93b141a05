#include "engine/geometry/triangle_distance.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "tests/support/campaign.h"
#include "tests/support/random.h"

namespace feder {
namespace {

// A quarter of them segments, points or needles.
Triangle random_triangle(Random& random) {
  Triangle t{random.vector(), random.vector(), random.vector()};
  const int kind = random.below(12);
  if (kind == 0) t[2] = t[1];
  if (kind == 1) t[2] = 0.3 * t[0] + 0.7 * t[1];
  if (kind == 2) t = {t[0], t[0], t[0]};
  return t;
}
Vector3d random_point_of(Random& random, const Triangle& t) {
  double u = random.uniform(0.0, 1.0), v = random.uniform(0.0, 1.0);
  if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
  return t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]);
}
// How far x is from the triangle, by its own plane and edges.
double off(const Triangle& t, const Vector3d& x) {
  return std::sqrt(closest_point(t, x).distance_squared);
}

// Nearest, by the condition of a convex set: (p - c).(x - c) <= 0 for its corners x; largest 4e-16.
TEST(TriangleDistanceCampaign, PointIsNearestByTheVariationalInequality) {
  for (int seed = 0; seed < test::campaign_cases(1000000); ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    const Triangle t = random_triangle(random);
    const Vector3d p = random.vector(2.0);
    const TrianglePoint c = closest_point(t, p);
    for (const Vector3d& x : t) ASSERT_LE((p - c.point).dot(x - c.point), 1e-14) << "seed " << seed;
    ASSERT_EQ(c.distance_squared, (p - c.point).squaredNorm()) << "seed " << seed;
    if (c.feature == Feature::kVertex) ASSERT_EQ(c.point, t[static_cast<std::size_t>(c.index)]);
  }
}

// Disjoint: a plane across the nearest pair separates, so the distance is neither too large nor too small.
TEST(TriangleDistanceCampaign, PairIsNearestByItsSeparatingPlane) {
  int apart = 0;
  for (int seed = 0; seed < test::campaign_cases(1000000); ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    const Triangle a = random_triangle(random);
    Triangle b = random_triangle(random);
    const Vector3d move = random.vector(1.5);
    for (Vector3d& x : b) x += move;
    const ClosestPair c = closest_points(a, b);
    ASSERT_LE(off(a, c.a), 1e-13) << "seed " << seed;
    ASSERT_LE(off(b, c.b), 1e-13) << "seed " << seed;
    if (overlap(a, b)) {
      ASSERT_LE(c.distance_squared, 1e-24) << "seed " << seed;
      continue;
    }
    ++apart;
    const Vector3d n = c.b - c.a;
    for (const Vector3d& x : a) ASSERT_LE(n.dot(x - c.a), 1e-14) << "seed " << seed;
    for (const Vector3d& x : b) ASSERT_GE(n.dot(x - c.b), -1e-14) << "seed " << seed;
  }
  EXPECT_GT(apart, test::campaign_cases(1000000) / 4);
}

TEST(TriangleDistanceCampaign, RayThroughAPointOfTheTriangleHitsItThere) {
  for (int seed = 0; seed < test::campaign_cases(1000000); ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    const Triangle t{random.vector(), random.vector(), random.vector()};
    const Vector3d x = 0.99 * random_point_of(random, t) + 0.01 / 3.0 * (t[0] + t[1] + t[2]);
    const Vector3d origin = random.vector(2.0), normal = (t[1] - t[0]).cross(t[2] - t[0]);
    if (std::abs(normal.dot(x - origin)) < 1e-3) continue;  // along the plane, or a needle
    const auto hit = ray_hit(t, origin, 2.0 * (x - origin), 1.0);
    ASSERT_TRUE(hit) << "seed " << seed;
    ASSERT_NEAR(*hit, 0.5, 1e-12) << "seed " << seed;
    ASSERT_FALSE(ray_hit(t, origin, 2.0 * (x - origin), 0.49)) << "seed " << seed;
    ASSERT_FALSE(ray_hit(t, origin, origin - x, 10.0)) << "seed " << seed;
  }
}

TEST(TriangleDistance, RayAlongThePlaneMisses) {
  EXPECT_FALSE(ray_hit({Vector3d{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {-1, 0.25, 0}, {1, 0, 0}, 10.0));
}

}  // namespace
}  // namespace feder
