// Differences of products and cross products against exact rationals.
#include "engine/geometry/accurate_vectors.h"

#include <gmpxx.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "tests/support/random.h"

namespace feder {
namespace {

// d is such that a b - c d cancels: to rounding, to 1e-9, or not at all.
double cancelling(Random& random, double a, double b, double c, int trial) {
  const double d = a * b / c;
  switch (trial % 4) {
    case 0:
      return d;
    case 1:
      return std::nextafter(d, 2.0);
    case 2:
      return d * (1.0 + 1e-9 * random.uniform());
    default:
      return random.uniform();
  }
}

TEST(DifferenceOfProducts, IsGoodToTwoRoundingsHoweverMuchCancels) {
  Random random(1);
  double worst = 0.0, worst_plain = 0.0;
  for (int trial = 0; trial < 100000; ++trial) {
    const double a = random.uniform(), b = random.uniform(), c = random.uniform();
    const double d = cancelling(random, a, b, c, trial);
    const double found = difference_of_products(a, b, c, d), plain = a * b - c * d;
    EXPECT_EQ(found, -difference_of_products(c, d, a, b));
    const mpq_class exact = mpq_class(a) * mpq_class(b) - mpq_class(c) * mpq_class(d);
    if (exact == 0) {
      EXPECT_EQ(found, 0.0);
      continue;
    }
    const auto error = [&](double x) { return std::abs(mpq_class((mpq_class(x) - exact) / exact).get_d()); };
    worst = std::max(worst, error(found));
    worst_plain = std::max(worst_plain, error(plain));
  }
  EXPECT_LT(worst, 4.5e-16);    // 2.2e-16
  EXPECT_GT(worst_plain, 0.5);  // 206
}

TEST(AccurateCross, OfNearlyParallelVectorsPointsTheRightWay) {
  Random random(2);
  double worst = 0.0, worst_plain = 0.0;
  for (int trial = 0; trial < 2000; ++trial) {
    const Vector3d a = random.vector(), b = 1.7 * a + 1e-10 * random.vector();
    const Vector3d found = accurate_cross(a, b), plain = a.cross(b);
    EXPECT_EQ(found, -accurate_cross(b, a));
    Vector3d exact;
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      exact[k] = mpq_class(mpq_class(a[i]) * mpq_class(b[j]) - mpq_class(a[j]) * mpq_class(b[i])).get_d();
    }
    worst = std::max(worst, found.normalized().cross(exact.normalized()).norm());
    worst_plain = std::max(worst_plain, plain.normalized().cross(exact.normalized()).norm());
  }
  EXPECT_LT(worst, 1e-15);       // 2e-16
  EXPECT_GT(worst_plain, 1e-7);  // 4e-5
}

TEST(Grid, MakesDifferencesExactAndMovesNothingFar) {
  Random random(3);
  for (int trial = 0; trial < 2000; ++trial) {
    const double size = std::pow(10.0, random.uniform(-9.0, 9.0));
    const Vector3d low = random.vector(size), high = low + size * (random.vector() + Vector3d::Ones());
    const Grid grid(Aabb{low, high});
    const Vector3d p = low + random.uniform(0.0, 1.0) * (high - low),
                   q = high - random.uniform(0.0, 1.0) * (high - low);
    const Vector3d x = grid(p), y = grid(q);
    EXPECT_LE(x.cwiseAbs().maxCoeff(), 1.0);
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(mpq_class(x[k]) - mpq_class(y[k]), mpq_class(x[k] - y[k]));
      EXPECT_EQ(std::ldexp(x[k], 50), std::nearbyint(std::ldexp(x[k], 50)));
    }
    const double moved = (grid.length() * (x - y) - (p - q)).cwiseAbs().maxCoeff();
    EXPECT_LT(moved / (high - low).maxCoeff(), 4e-15);  // 9e-16
  }
}

TEST(Grid, OfASinglePointIsThatPoint) {
  const Vector3d p(1, 2, 3);
  const Grid grid(Aabb{p, p});
  EXPECT_EQ(grid(p), Vector3d::Zero());
  EXPECT_EQ(grid.world(grid(p)), p);
}

}  // namespace
}  // namespace feder
