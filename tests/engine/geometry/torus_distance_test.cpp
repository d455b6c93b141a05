// Circles and tori in space (notes C10) against sampled minima and closed forms.
#include "engine/geometry/torus_distance.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "engine/check.h"
#include "tests/engine/geometry/box_pairs.h"
#include "tests/support/campaign.h"
#include "tests/support/random.h"

namespace feder {
namespace {

using std::numbers::pi;

Circle circle(const Vector3d& centre, const Vector3d& normal, double radius) {
  return {centre, normal, radius};
}

Vector3d point_of(const Circle& c, double angle) {
  const Vector3d z = c.normal.normalized(), x = z.unitOrthogonal();
  return c.centre + c.radius * (std::cos(angle) * x + std::sin(angle) * z.cross(x));
}

/// Least distance of a lattice of points of b from circle a; at most `error` above the true one.
double sampled_distance(const Circle& a, const Circle& b, int count, double& error) {
  const Vector3d n = a.normal.normalized();
  double least = INFINITY;
  for (int k = 0; k < count; ++k) {
    const Vector3d d = point_of(b, 2.0 * pi * k / count) - a.centre;
    const double height = n.dot(d), across = (d - height * n).norm();
    least = std::min(least, std::hypot(height, across - a.radius));
  }
  error = b.radius * pi / count;
  return least;
}

Circle random_circle(Random& random) {
  return circle(random.vector(), random.vector(), random.uniform(0.0, 1.5));
}

/// Common axis, common centre, one plane, linked, touching, points, small on large, nearly so.
std::pair<Circle, Circle> random_circles(Random& random) {
  Circle a = random_circle(random), b = random_circle(random);
  const double small = random.below(2) ? 0.0 : test::random_size(random, -15.0, -1.0);
  switch (random.below(9)) {
    case 0:
      b.normal = a.normal + small * random.vector();
      break;
    case 1:
      b.centre = a.centre + small * random.vector();
      break;
    case 2:
      b.normal = a.normal;
      b.centre = a.centre + random.uniform() * a.normal + small * random.vector();
      break;
    case 3:
      b.centre = point_of(a, random.uniform(-pi, pi)) + small * random.vector();
      break;
    case 4:
      b.centre += point_of(a, 1.0) - point_of(b, 2.0) + small * random.vector();
      break;
    case 5:
      b.radius = small;
      break;
    case 6:
      b.radius = a.radius * test::random_size(random, -6.0, 0.0);
      break;
    case 7:
      b = a;
      b.centre += small * random.vector();
      b.normal += small * random.vector();
      break;
    default:
      break;
  }
  return {a, b};
}

TEST(CircleCampaign, DistanceIsTheSampledMinimum) {
  constexpr std::uint64_t kSeed = 20130504;
  Random random(kSeed);
  const int cases = test::campaign_cases(100000);
  double worst_above = 0.0, worst_asymmetry = 0.0, worst_points = 0.0;
  for (int k = 0; k < cases; ++k) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", case " + std::to_string(k));
    const auto [a, b] = random_circles(random);
    const CircleDistance found = distance(a, b), turned = distance(b, a);
    double error = 0.0;
    const double sampled = sampled_distance(a, b, 400, error);
    // no sample is closer, and it is no closer than the samples allow
    worst_above = std::max(worst_above, found.distance - sampled);
    EXPECT_GT(found.distance, sampled - error - 1e-14);
    worst_asymmetry = std::max(worst_asymmetry, std::abs(found.distance - turned.distance));

    // it is the distance of two points, one on each circle
    const auto off = [](const Circle& c, const Vector3d& p) {
      const Vector3d d = p - c.centre;
      const double height = c.normal.normalized().dot(d);
      return std::hypot(height, (d - height * c.normal.normalized()).norm() - c.radius);
    };
    worst_points = std::max({worst_points, off(a, found.point_a), off(b, found.point_b),
                             std::abs((found.point_b - found.point_a).norm() - found.distance)});
  }
  EXPECT_LT(worst_above, 1e-12);  // 8e-16; all: 2.8e-13, circles that nearly coincide
  EXPECT_EQ(worst_asymmetry, 0.0);
  EXPECT_LT(worst_points, 1e-13);  // 1.1e-15; all: 1.8e-15
  std::printf("%d pairs of circles: above the samples %.2g, asymmetry %.2g, points %.2g\n", cases,
              worst_above, worst_asymmetry, worst_points);
}

TEST(Circle, DistanceAgreesWithClosedForms) {
  const Circle unit = circle({0, 0, 0}, {0, 0, 1}, 1.0);
  const auto to = [&](const Vector3d& centre, const Vector3d& normal, double radius) {
    return distance(unit, circle(centre, normal, radius)).distance;
  };
  EXPECT_NEAR(to({0, 0, 2}, {0, 0, 1}, 1.0), 2.0, 1e-15);                   // common axis
  EXPECT_NEAR(to({0, 0, 2}, {0, 0, 5}, 0.5), std::hypot(2.0, 0.5), 1e-15);  // a cone
  EXPECT_NEAR(to({3, 0, 0}, {0, 0, 1}, 1.0), 1.0, 1e-15);                   // one plane, outside
  EXPECT_NEAR(to({0.1, 0, 0}, {0, 0, 1}, 0.5), 0.4, 1e-15);                 // one plane, inside
  EXPECT_NEAR(to({1.5, 0, 0}, {0, 0, 1}, 1.0), 0.0, 1e-15);                 // one plane, crossing
  EXPECT_NEAR(to({1, 0, 0}, {0, 1, 0}, 0.25), 0.25, 1e-15);                 // linked
  EXPECT_NEAR(to({0, 0, 0}, {1, 0, 0}, 2.0), 1.0, 1e-15);                   // common centre
  EXPECT_NEAR(to({0, 0, 0}, {1, 0, 0}, 1.0), 0.0, 1e-15);                   // meeting twice
  EXPECT_NEAR(to({0, 0, 3}, {1, 1, 1}, 0.0), std::sqrt(10.0), 1e-15);       // a point on the axis
  EXPECT_NEAR(to({0, 0, 0}, {0, 0, 1}, 1.0), 0.0, 1e-15);                   // the same circle
  const Circle point = circle({1, 2, 3}, {0, 0, 1}, 0.0);
  EXPECT_EQ(distance(point, point).distance, 0.0);
}

TEST(Circle, NearestOfSeveralMinimaIsFound) {
  // a wide circle tilted over a small one has minima on both sides; a shift makes either the nearer
  const Circle small = circle({0, 0, 0}, {0, 0, 1}, 1.0);
  for (double shift : {-1e-3, 1e-3}) {
    const Circle wide = circle({shift, 0, 0}, {0, 1, 0}, 1.2);
    const CircleDistance found = distance(small, wide);
    EXPECT_NEAR(found.distance, 0.2 - 1e-3, 1e-15);
    EXPECT_LT(found.point_a.x() * shift, 0.0);
  }
}

TEST(Torus, GapIsTheDistanceOfTheSampledSurfaces) {
  Random random(2);
  int apart = 0;
  for (int trial = 0; trial < 20; ++trial) {
    Torus a{random_circle(random), 0.1}, b{random_circle(random), 0.15};
    a.circle.radius += 0.3;
    b.circle.radius += 0.3;
    b.circle.centre *= 2.0;
    const double found = gap(a, b);
    if (found <= 0.0) continue;
    ++apart;
    // lattices of both surfaces, 60 x 12 points each
    const auto surface = [](const Torus& t) {
      std::vector<Vector3d> out;
      for (int i = 0; i < 60; ++i)
        for (int j = 0; j < 12; ++j) {
          const Vector3d on_circle = point_of(t.circle, 2.0 * pi * i / 60), z = t.circle.normal.normalized();
          const Vector3d outward = (on_circle - t.circle.centre).normalized();
          out.push_back(on_circle + t.minor * (std::cos(pi * j / 6) * outward + std::sin(pi * j / 6) * z));
        }
      return out;
    };
    double least = INFINITY;
    for (const Vector3d& p : surface(a))
      for (const Vector3d& q : surface(b)) least = std::min(least, (p - q).norm());
    EXPECT_GE(least, found - 1e-14);
    EXPECT_LT(least, found + 0.2);  // half the mesh of both lattices: 0.12 + 0.08
  }
  EXPECT_GT(apart, 5);
}

TEST(Torus, TouchingCountsAsOverlap) {
  const Torus a{circle({0, 0, 0}, {0, 0, 1}, 2.0), 0.5}, b{circle({5, 0, 0}, {0, 0, 1}, 2.0), 0.5};
  EXPECT_NEAR(gap(a, b), 0.0, 1e-15);  // 4e-16
  EXPECT_TRUE(overlap(a, b));
  const Torus linked{circle({2, 0, 0}, {0, 1, 0}, 2.0), 0.5};
  EXPECT_FALSE(overlap(a, linked));
  EXPECT_NEAR(gap(a, linked), 1.0, 1e-15);
}

TEST(Torus, RefusesWhatIsNone) {
  const Circle good = circle({0, 0, 0}, {0, 0, 1}, 1.0);
  EXPECT_THROW((void)distance(good, circle({0, 0, 0}, {0, 0, 0}, 1.0)), MisuseError);
  EXPECT_THROW((void)distance(good, circle({0, 0, NAN}, {0, 0, 1}, 1.0)), MisuseError);
  EXPECT_THROW((void)distance(circle({0, 0, 0}, {0, 0, 1}, -1.0), good), MisuseError);
  EXPECT_THROW((void)gap(Torus{good, -0.1}, Torus{good, 0.1}), MisuseError);
}

}  // namespace
}  // namespace feder
