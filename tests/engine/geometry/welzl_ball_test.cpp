// Welzl's algorithm as the notes have it: its expected number of tests (A17), and its answers.
#include "engine/geometry/welzl_ball.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/random.h"

namespace feder {
namespace {

Eigen::MatrixXd random_points(Random& random, int d, int n) {
  Eigen::MatrixXd points(d, n);
  for (int i = 0; i < n; ++i) points.col(i) = random.numbers(d);
  return points;
}

VectorXd in_ball(Random& random, int d) {
  for (;;)
    if (const VectorXd x = random.numbers(d); x.squaredNorm() <= 1.0) return x;
}

// (d + 1)! sum_{j = 1 .. d + 1} 1/j!
double bound(int d) {
  double bound = 0.0, term = 1.0;
  for (int j = d + 1; j >= 1; --j) {
    bound += term;
    term *= j;
  }
  return bound;
}

TEST(WelzlBall, BoundOfTheNotesIsThreeTenFortyOne) {
  EXPECT_EQ(bound(1), 3.0);
  EXPECT_EQ(bound(2), 10.0);
  EXPECT_EQ(bound(3), 41.0);
  EXPECT_NEAR(bound(9) / 3628800.0, std::exp(1.0) - 1.0, 1e-6);
}

TEST(WelzlBall, ExpectedInsideTestsPerPointStayBelowTheBound) {
  constexpr int kRuns = 200, kPoints = 4000;
  double factorial = 1.0;
  for (int d : {1, 2, 3}) {
    factorial *= d;
    Random random(static_cast<std::uint64_t>(d));
    double sum = 0.0, squares = 0.0;
    for (int seed = 0; seed < kRuns; ++seed) {
      Eigen::MatrixXd points(d, kPoints);
      for (int i = 0; i < kPoints; ++i) points.col(i) = in_ball(random, d);
      const double tests = static_cast<double>(welzl_ball(points, seed).inside_tests) / kPoints;
      sum += tests;
      squares += tests * tests;
    }
    const double mean = sum / kRuns, sigma = std::sqrt((squares / kRuns - mean * mean) / kRuns);
    std::printf("d = %d: %.2f +- %.2f inside tests per point, bound %g\n", d, mean, sigma, bound(d));
    EXPECT_LT(mean, bound(d) + 3.0 * sigma) << "d " << d;   // 3.07 +- 0.07, 9.8 +- 0.3, 36.8 +- 1.5
    EXPECT_GT(mean, factorial + 3.0 * sigma) << "d " << d;  // "like d!", as printed, is too little
  }
}

TEST(WelzlBall, SeedChangesTheWorkAndNotTheAnswer) {
  Random random(9);
  const Eigen::MatrixXd points = random_points(random, 3, 500);
  const WelzlBall first = welzl_ball(points, 1), second = welzl_ball(points, 2),
                  again = welzl_ball(points, 1);
  EXPECT_NE(first.inside_tests, second.inside_tests);
  EXPECT_EQ(first.inside_tests, again.inside_tests);
  EXPECT_EQ(first.ball.radius, again.ball.radius);
  EXPECT_NEAR(first.ball.radius, second.ball.radius, 1e-14);
}

TEST(WelzlBall, TakesAMillionPointsInTheOrderTheyGrow) {
  Eigen::MatrixXd points(1, 1000000);
  for (int i = 0; i < 1000000; ++i) points(0, i) = i;  // every point is outside the ball of those before
  const WelzlBall found = welzl_ball(points, 3);
  EXPECT_EQ(found.ball.radius, 499999.5);
  EXPECT_LT(static_cast<double>(found.inside_tests), 20e6);
}

}  // namespace
}  // namespace feder
