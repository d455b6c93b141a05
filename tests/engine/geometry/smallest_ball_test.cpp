// Smallest enclosing balls (notes A13-A16) against normal equations, all subsets, and each other.
#include "engine/geometry/smallest_ball.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <limits>

#include "engine/geometry/welzl_ball.h"
#include "tests/support/campaign.h"
#include "tests/support/random.h"
#include "tests/support/refused.h"

namespace feder {
namespace {

using Eigen::MatrixXd;
using MatrixXl = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using VectorXl = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

MatrixXd random_points(Random& random, int d, int n) {
  MatrixXd points(d, n);
  for (int i = 0; i < n; ++i) points.col(i) = random.numbers(d);
  return points;
}

// How far the farthest point is outside, relative to the radius.
double outside(const MatrixXd& points, const Ball& ball) {
  return (points.colwise() - ball.centre).colwise().norm().maxCoeff() / ball.radius - 1.0;
}

// c = p_0 + Q mu, 2 Q^T Q mu = diag(Q^T Q) in extended precision; radius < 0 where Q has no full rank.
Ball by_normal_equations(const MatrixXd& points) {
  const VectorXl first = points.col(0).cast<long double>();
  const MatrixXl Q = points.rightCols(points.cols() - 1).cast<long double>().colwise() - first;
  if (Q.cols() == 0) return {points.col(0), 0.0};
  const MatrixXl G = Q.transpose() * Q;
  Eigen::FullPivLU<MatrixXl> lu(G);
  lu.setThreshold(1e-15L);
  if (lu.rank() < G.rows()) return {points.col(0)};
  const VectorXl offset = Q * lu.solve(0.5L * G.diagonal());
  return {(first + offset).cast<double>(), static_cast<double>(offset.norm())};
}

// The smallest among the balls through at most d + 1 of the points that contain all of them.
Ball by_subsets(const MatrixXd& points) {
  const int d = static_cast<int>(points.rows()), n = static_cast<int>(points.cols());
  Ball best{points.col(0), std::numeric_limits<double>::infinity()};
  for (unsigned set = 1; set < (1u << n); ++set) {
    const int k = __builtin_popcount(set);
    if (k > d + 1) continue;
    MatrixXd some(d, k);
    for (int i = 0, j = 0; i < n; ++i)
      if (set >> i & 1u) some.col(j++) = points.col(i);
    const Ball ball = by_normal_equations(some);
    if (ball.radius < 0.0 || ball.radius >= best.radius) continue;
    if ((points.colwise() - ball.centre).colwise().norm().maxCoeff() <= ball.radius + 1e-12) best = ball;
  }
  return best;
}

constexpr int kKinds = 9;

// Size about 1, in all the positions that make a simplex or a support set degenerate.
MatrixXd degenerate_points(Random& random, int d, int n, int kind) {
  MatrixXd points = random_points(random, d, n);
  switch (kind) {
    case 0:  // general position
      break;
    case 1:  // duplicates
      for (int i = 0; i < n; ++i) points.col(i) = VectorXd(points.col(random.below(n)));
      break;
    case 2: {  // in one hyperplane
      if (d == 1) break;
      const VectorXd normal = random.numbers(d).normalized();
      points -= normal * (normal.transpose() * points).eval();
      points.colwise() += normal;
      break;
    }
    case 3: {  // on one line
      const VectorXd direction = random.numbers(d), start = random.numbers(d);
      for (int i = 0; i < n; ++i) points.col(i) = start + random.uniform() * direction;
      break;
    }
    case 4:  // on one sphere
      points.colwise().normalize();
      break;
    case 5:  // on one circle or lower-dimensional sphere
      points.bottomRows(d / 2).setConstant(0.3);
      points.topRows(d - d / 2).colwise().normalize();
      break;
    case 6:  // corners of a cube
      points = points.array().sign().matrix();
      break;
    case 7:  // close pairs, with room for the extended precision of the subsets
      for (int i = 1; i < n; i += 2)
        points.col(i) = points.col(i - 1) + (random.below(2) ? 1e-5 : 1e-14) * random.numbers(d);
      break;
    default:  // antipodal pairs
      for (int i = 1; i < n; i += 2) points.col(i) = -points.col(i - 1);
  }
  return points;
}

TEST(BallThrough, IsEquidistantFromItsPointsWithItsCentreInTheirHull) {
  double worst = 0.0, worst_hull = 0.0;
  for (int d = 1; d <= 6; ++d)
    for (int k = 1; k <= d + 1; ++k)
      for (int seed = 0; seed < 200; ++seed) {
        SCOPED_TRACE("d " + std::to_string(d) + ", k " + std::to_string(k) + ", seed " +
                     std::to_string(seed));
        Random random(static_cast<std::uint64_t>(seed));
        const MatrixXd points = random_points(random, d, k);
        const std::optional<Ball> ball = ball_through(points);
        ASSERT_TRUE(ball.has_value());
        const VectorXd distance = (points.colwise() - ball->centre).colwise().norm();
        if (k > 1) worst = std::max(worst, (distance.maxCoeff() - distance.minCoeff()) / ball->radius);
        const MatrixXd Q = points.rightCols(k - 1).colwise() - VectorXd(points.col(0));
        const VectorXd c = ball->centre - points.col(0);
        if (k > 1)
          worst_hull = std::max(worst_hull, (Q * Q.colPivHouseholderQr().solve(c) - c).norm() / ball->radius);
      }
  EXPECT_LT(worst, 1e-12);       // 1.2e-15
  EXPECT_LT(worst_hull, 1e-12);  // 3e-13
}

TEST(BallThrough, SolvesTheNormalEquationsOfTheNotes) {
  Random random(1);
  for (int d = 1; d <= 6; ++d)
    for (int k = 1; k <= d + 1; ++k) {
      const MatrixXd points = random_points(random, d, k);
      const Ball expected = by_normal_equations(points);
      ASSERT_GE(expected.radius, 0.0);
      const std::optional<Ball> ball = ball_through(points);
      ASSERT_TRUE(ball.has_value());
      EXPECT_LT((ball->centre - expected.centre).norm(), 1e-12 * (1.0 + expected.radius));
    }
}

TEST(BallThrough, ReportsAffinelyDependentPoints) {
  Random random(2);
  for (int d = 1; d <= 6; ++d)
    for (int k = 2; k <= d + 1; ++k)
      for (int trial = 0; trial < 50; ++trial) {
        MatrixXd points = random_points(random, d, k);
        VectorXd weights = random.numbers(k - 1);
        weights /= weights.sum();
        points.col(k - 1) = points.leftCols(k - 1) * weights;  // k = 2: a duplicate
        EXPECT_FALSE(ball_through(points).has_value()) << "d " << d << ", k " << k;
      }
}

TEST(BallThrough, KeepsTheDigitsOfAClosePair) {
  // two points 2e apart at the end of a diameter: seen from the far end their directions agree to e
  for (double e : {1e-3, 1e-6, 1e-9}) {
    MatrixXd points(2, 3);
    points << -1.0, std::sqrt(1.0 - e * e), std::sqrt(1.0 - e * e), 0.0, e, -e;
    const std::optional<Ball> ball = ball_through(points);
    ASSERT_TRUE(ball.has_value());
    EXPECT_NEAR(ball->radius, 1.0, 1e-15) << e;
    EXPECT_LT(ball->centre.norm(), 1e-15) << e;
  }
}

TEST(BallThrough, RefusesNoPointsAndTooMany) {
  EXPECT_THROW((void)ball_through(MatrixXd(3, 0)), MisuseError);
  EXPECT_THROW((void)ball_through(MatrixXd::Random(3, 5)), MisuseError);
  EXPECT_FALSE(ball_through(MatrixXd::Constant(3, 1, std::numeric_limits<double>::quiet_NaN())).has_value());
}

TEST(SmallestBallCampaign, AgreesWithAllSubsetsOfUpToTwelvePoints) {
  const int cases = test::campaign_cases(100000);
  double worst = 0.0, worst_outside = 0.0, worst_welzl = 0.0;
  for (int seed = 0; seed < cases; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    const int d = 1 + seed % 6, kind = seed / 6 % kKinds, n = 1 + random.below(12);
    SCOPED_TRACE("seed " + std::to_string(seed) + ", d " + std::to_string(d) + ", n " + std::to_string(n) +
                 ", kind " + std::to_string(kind));
    const MatrixXd points = degenerate_points(random, d, n, kind);
    const Ball ball = smallest_ball(points), expected = by_subsets(points);
    const double error = std::abs(ball.radius - expected.radius);
    EXPECT_LT(error, 1e-10);  // 6e-13, what the subsets are allowed to leave outside
    if (ball.radius > 0.0) worst_outside = std::max(worst_outside, outside(points, ball));
    worst = std::max(worst, error);
    const double welzl = std::abs(welzl_ball(points, 5).ball.radius - expected.radius);
    EXPECT_LT(welzl, 1e-10);
    worst_welzl = std::max(worst_welzl, welzl);
  }
  EXPECT_LT(worst_outside, 1e-14);  // 4e-16
  std::printf("radius %.1e, outside %.1e, Welzl %.1e\n", worst, worst_outside, worst_welzl);
}

// The points on the boundary, to rounding and a little more.
MatrixXd boundary(const MatrixXd& points, const Ball& ball) {
  MatrixXd on(points.rows(), 0);
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    if ((points.col(i) - ball.centre).norm() > (1.0 - 1e-9) * ball.radius) {
      on.conservativeResize(Eigen::NoChange, on.cols() + 1);
      on.rightCols(1) = points.col(i);
    }
  return on;
}

TEST(SmallestBallCampaign, OfManyPointsCannotMoveInAnyDirection) {
  for (int seed = 0; seed < test::campaign_cases(900); ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    const int d = 1 + seed % 6, kind = seed / 6 % kKinds, n = 15000 + random.below(15000);
    SCOPED_TRACE("seed " + std::to_string(seed) + ", d " + std::to_string(d) + ", kind " +
                 std::to_string(kind));
    const MatrixXd points = degenerate_points(random, d, n, kind);
    const Ball ball = smallest_ball(points);
    EXPECT_LE(outside(points, ball), 1e-14);
    const MatrixXd on = boundary(points, ball);
    for (int trial = 0; trial < 50; ++trial) {
      const VectorXd shifted = ball.centre + 1e-3 * random.numbers(d).normalized();
      EXPECT_GT((on.colwise() - shifted).colwise().norm().maxCoeff(), ball.radius);
    }
    if (d <= 3) {
      EXPECT_NEAR(welzl_ball(points, 7).ball.radius, ball.radius, 1e-12);
    }
  }
}

TEST(SmallestBall, DoesNotDependOnTheOrderOfThePoints) {
  for (int seed = 0; seed < 60; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    SCOPED_TRACE("seed " + std::to_string(seed));
    MatrixXd points = degenerate_points(random, 1 + seed % 6, 20, seed % kKinds);
    const Ball ball = smallest_ball(points);
    for (int i = 19; i > 0; --i) points.col(i).swap(points.col(random.below(i + 1)));
    const Ball again = smallest_ball(points);
    EXPECT_NEAR(again.radius, ball.radius, 1e-14);
    // notes A14: two centres apart would leave a smaller ball, |c1 - c2|^2 <= 4 (r^2 - r_min^2)
    EXPECT_LT((again.centre - ball.centre).norm(), 1e-7);
  }
}

TEST(SmallestBall, IsUniqueBecauseTheBallBetweenTwoIsSmaller) {
  double gain = 0.0;
  for (int seed = 0; seed < 500; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    SCOPED_TRACE("seed " + std::to_string(seed));
    const int d = 1 + seed % 6;
    const MatrixXd points = random_points(random, d, 30);
    const VectorXd c1 = random.numbers(d), c2 = random.numbers(d);
    auto farthest = [&](const VectorXd& c) { return (points.colwise() - c).colwise().norm().maxCoeff(); };
    const double r = std::max(farthest(c1), farthest(c2));
    const double smaller = std::sqrt(r * r - 0.25 * (c1 - c2).squaredNorm());
    EXPECT_LE(farthest(0.5 * (c1 + c2)), smaller * (1.0 + 1e-15));
    EXPECT_LE(smallest_ball(points).radius, smaller);
    gain = std::max(gain, r - smaller);
  }
  EXPECT_GT(gain, 0.1);  // 0.51
}

TEST(SmallestBall, BlendedBallsShareTheirIntersectionAndHaveAConvexRadius) {
  // notes A16: r^2 = (1 - l) r0^2 + l r1^2 - l (1 - l) |c0 - c1|^2
  double worst = 0.0;
  for (int seed = 0; seed < 500; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    const int d = 1 + seed % 6;
    const VectorXd c0 = random.numbers(d), c1 = random.numbers(d), x = random.numbers(d);
    const double r0 = random.uniform(0.0, 1.0), r1 = random.uniform(0.0, 1.0), l = random.uniform(0.0, 1.0);
    const double apart = (c0 - c1).squaredNorm();
    auto squared = [&](double t) { return (1 - t) * r0 * r0 + t * r1 * r1 - t * (1 - t) * apart; };
    const double blended =
        (1 - l) * ((x - c0).squaredNorm() - r0 * r0) + l * ((x - c1).squaredNorm() - r1 * r1);
    const double of_ball = (x - (1 - l) * c0 - l * c1).squaredNorm() - squared(l);
    worst = std::max(worst, std::abs(blended - of_ball));
    const double second = (squared(l + 1e-2) - 2.0 * squared(l) + squared(l - 1e-2)) / 1e-4;
    EXPECT_NEAR(second, 2.0 * apart, 1e-10);
  }
  EXPECT_LT(worst, 1e-14);  // 1.8e-15
}

TEST(SmallestBall, OfEqualPointsIsThatPoint) {
  for (int n : {1, 2, 7, 20000}) {
    const Vector3d x(0.1, -0.7, 1e9);
    const Ball ball = smallest_ball(x.replicate(1, n));
    EXPECT_EQ(ball.centre, x) << n;
    EXPECT_EQ(ball.radius, 0.0) << n;
  }
  EXPECT_LT(smallest_ball(MatrixXd(3, 0)).radius, 0.0);
}

TEST(SmallestBall, FindsTheOutliersASampleMisses) {
  for (int outliers = 1; outliers <= 40; ++outliers) {
    SCOPED_TRACE(outliers);
    Random random(static_cast<std::uint64_t>(outliers));
    MatrixXd points = random_points(random, 3, 100000);
    MatrixXd far(3, outliers);
    for (int i = 0; i < outliers; ++i) {
      far.col(i) = (2.0 + std::pow(10.0, -0.1 * i)) * random.vector().normalized();
      points.col(random.below(100000)) = far.col(i);
    }
    const Ball ball = smallest_ball(points);
    EXPECT_LE(outside(points, ball), 1e-15);
    EXPECT_NEAR(ball.radius, welzl_ball(points, 3).ball.radius, 1e-13);
  }
}

TEST(SmallestBall, TakesAMillionPointsOnASphereAndInside) {
  Random random(4);
  MatrixXd points = random_points(random, 3, 1000000);
  for (int i = 0; i < 1000000; i += 2) points.col(i).normalize();
  for (int i = 1; i < 1000000; i += 2) points.col(i) /= std::sqrt(3.0);
  const Ball ball = smallest_ball(points);
  EXPECT_NEAR(ball.radius, 1.0, 1e-14);
  EXPECT_LT(ball.centre.norm(), 1e-13);
  EXPECT_LE(outside(points, ball), 1e-15);
}

TEST(SmallestBall, ReadsColumnsOfALargerMatrix) {
  Random random(5);
  const MatrixXd large = random_points(random, 5, 40);
  const MatrixXd copy = large.middleRows(1, 3);
  EXPECT_EQ(smallest_ball(large.middleRows(1, 3)).radius, smallest_ball(copy).radius);
}

TEST(SmallestBall, ScalesWithThePointsOverTheWholeRange) {
  Random random(6);
  for (int n : {20, 20000}) {
    const MatrixXd points = random_points(random, 3, n);
    const double radius = smallest_ball(points).radius;
    for (int exponent : {-1000, -600, 600, 1020})
      EXPECT_NEAR(std::ldexp(smallest_ball(points * std::ldexp(1.0, exponent)).radius, -exponent), radius,
                  1e-15 * radius)
          << exponent;
  }
}

TEST(SmallestBall, FarFromTheOriginKeepsWhatTheCoordinatesHold) {
  Random random(7);
  for (double distance : {1e3, 1e6, 1e9}) {
    const MatrixXd points = random_points(random, 3, 1000);
    const MatrixXd moved = (points.array() + distance).matrix();
    const Ball ball = smallest_ball(moved);
    EXPECT_LE(outside(moved, ball), 1e-15);
    EXPECT_NEAR(ball.radius, smallest_ball(points).radius, 4e-16 * distance) << distance;
  }
}

TEST(SmallestBall, NamesAPointThatIsNotFinite) {
  Random random(8);
  for (double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    for (int n : {10, 20000})
      for (int at : {0, n / 3, n - 1}) {
        MatrixXd points = random_points(random, 3, n);
        points(1, at) = bad;
        const std::string text = "point " + std::to_string(at) + ": coordinate = ";
        EXPECT_TRUE(test::refused(text, [&] { (void)smallest_ball(points); }));
        EXPECT_TRUE(test::refused(text, [&] { (void)welzl_ball(points, 1); }));
      }
  EXPECT_THROW((void)smallest_ball(MatrixXd(0, 3)), MisuseError);
}

}  // namespace
}  // namespace feder
