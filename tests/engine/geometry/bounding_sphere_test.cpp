// The ball about the mean (notes A2): contains all points, and its radius is at most 2 (1 - 1/n) times the
// smallest one.
#include "engine/geometry/bounding_sphere.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "engine/geometry/smallest_ball.h"
#include "tests/support/campaign.h"
#include "tests/support/random.h"
#include "tests/support/refused.h"

namespace feder {
namespace {

double smallest_radius(const std::vector<Vector3d>& points) {
  return smallest_ball(Eigen::Map<const Eigen::MatrixXd>(points[0].data(), 3, std::ssize(points))).radius;
}

double factor(const std::vector<Vector3d>& points) {
  return bounding_sphere(points).radius / smallest_radius(points);
}

TEST(BoundingSphereCampaign, ContainsAllPointsWithinTheSharpFactor) {
  double largest = 0.0;
  for (int seed = 0; seed < test::campaign_cases(20000); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(static_cast<std::uint64_t>(seed));
    std::vector<Vector3d> points(2 + random.below(60));
    for (Vector3d& x : points) x = random.vector().cwiseProduct(random.vector());
    const int n = static_cast<int>(points.size());
    for (int i = random.below(n); i < n; ++i) points[i] = points[0];  // a heavy pole
    points[1] = random.vector();
    const Sphere sphere = bounding_sphere(points);
    for (const Vector3d& x : points) ASSERT_LE((x - sphere.centre).norm(), sphere.radius * (1.0 + 1e-15));
    const double bound = 2.0 * (1.0 - 1.0 / n), found = factor(points);
    EXPECT_LE(found, bound * (1.0 + 1e-14));
    largest = std::max(largest, found);
  }
  EXPECT_GT(largest, 1.5);  // 1.97: the bound is reached for, not out of sight
}

TEST(BoundingSphere, PointsAtOnePoleAndOneOppositeAttainTheFactor) {
  for (int n : {2, 3, 10, 1000}) {
    std::vector<Vector3d> points(n, Vector3d(1.0, 2.0, 3.0));
    points.back() = -points.front();
    EXPECT_NEAR(factor(points), 2.0 * (1.0 - 1.0 / n), 1e-14) << n;  // 4e-16
  }
}

TEST(BoundingSphere, OfEqualPointsIsThatPoint) {
  const Vector3d x(0.1, -0.7, 1e9);
  for (int n : {1, 3, 7}) {
    const Sphere sphere = bounding_sphere(std::vector<Vector3d>(n, x));
    EXPECT_EQ(sphere.centre, x);
    EXPECT_EQ(sphere.radius, 0.0);
  }
  EXPECT_LT(bounding_sphere({}).radius, 0.0);
}

TEST(BoundingSphere, ScalesWithThePointsOverTheWholeRange) {
  Random random(1);
  std::vector<Vector3d> points(20);
  for (Vector3d& x : points) x = random.vector();
  const Sphere sphere = bounding_sphere(points);
  for (int exponent : {-1000, -600, 600, 1000}) {
    std::vector<Vector3d> scaled = points;
    for (Vector3d& x : scaled) x *= std::ldexp(1.0, exponent);
    EXPECT_EQ(bounding_sphere(scaled).radius, std::ldexp(sphere.radius, exponent)) << exponent;
  }
}

TEST(BoundingSphere, NamesAPointThatIsNotFinite) {
  for (double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    std::vector<Vector3d> points(5, Vector3d::Ones());
    points[3].y() = bad;
    EXPECT_TRUE(test::refused("point 3: coordinate = ", [&] { bounding_sphere(points); }));
  }
}

}  // namespace
}  // namespace feder
