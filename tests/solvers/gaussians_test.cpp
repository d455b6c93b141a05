// Sums of Gaussians (notes I1): overlaps against quadrature and closed forms, gradients against differences,
// fits against known sums.
#include "engine/gaussians.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "solvers/gaussian_fit.h"
#include "tests/support/finite_difference.h"
#include "tests/support/random.h"
#include "tests/support/refused.h"

namespace feder {
namespace {

using std::numbers::pi;

GaussianSum random_sum(std::uint64_t seed, int dimension, int count) {
  Random random(seed);
  GaussianSum sum(dimension);
  for (int k = 0; k < count; ++k) {
    const double weight = random.uniform(0.5, 2.0) * (random.below(2) ? 1.0 : -1.0);
    const VectorXd centre = random.numbers(dimension);
    sum.add(weight, centre, random.uniform(0.4, 1.2));
  }
  return sum;
}

// Trapezoidal rule over [-8, 8]^d: spectrally accurate for what has died down at the ends.
double quadrature(const GaussianSum& a, const GaussianSum& b, int cells) {
  const int d = a.dimension;
  const double step = 16.0 / cells;
  VectorXd x(d);
  long double total = 0.0;  // half a million terms
  long points = 1;
  for (int i = 0; i < d; ++i) points *= cells;
  for (long p = 0; p < points; ++p) {
    long rest = p;
    for (int i = 0; i < d; ++i, rest /= cells) x[i] = -8.0 + step * static_cast<double>(rest % cells);
    total += evaluate(a, x) * evaluate(b, x);
  }
  return static_cast<double>(total) * std::pow(step, d);
}

GaussianSum unit(const VectorXd& centre, double width) {
  GaussianSum sum(static_cast<int>(centre.size()));
  sum.add(1.0, centre, width);
  return sum;
}

TEST(GaussianOverlap, EqualsQuadratureInOneTwoAndThreeDimensions) {
  for (int d = 1; d <= 3; ++d)
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const GaussianSum a = random_sum(seed, d, 1), b = random_sum(seed + 10, d, 1);
      const double expected = quadrature(a, b, 80) / (a.weight(0) * b.weight(0));
      ASSERT_GT(expected, 1e-3);
      const double value = overlap(a.centre(0), a.log_width(0), b.centre(0), b.log_width(0)).value();
      EXPECT_NEAR(value / expected, 1.0, 1e-13) << d;  // measured 4e-16
    }
}

// As it would be printed with the exponent d instead of d/2.
double wrong_exponent(const GaussianSum& a, const GaussianSum& b) {
  const double sa = std::exp(2.0 * a.log_width(0)), sb = std::exp(2.0 * b.log_width(0));
  return std::pow(2.0 * pi * sa * sb / (sa + sb), a.dimension) *
         std::exp(-(a.centre(0) - b.centre(0)).squaredNorm() / (2.0 * (sa + sb)));
}

TEST(GaussianOverlap, ExponentDInsteadOfHalfOfItMissesTheQuadrature) {
  for (int d = 1; d <= 3; ++d) {
    const GaussianSum a = random_sum(1, d, 1), b = random_sum(11, d, 1);
    const double expected = quadrature(a, b, 80) / (a.weight(0) * b.weight(0));
    EXPECT_GT(std::abs(wrong_exponent(a, b) / expected - 1.0), 0.1) << d;
  }
}

TEST(GaussianOverlap, OfSumsEqualsQuadrature) {
  for (int d = 1; d <= 3; ++d) {
    const GaussianSum a = random_sum(5, d, 3), b = random_sum(6, d, 2);
    const double expected = quadrature(a, b, 80);
    ASSERT_GT(std::abs(expected), 1e-2);
    EXPECT_NEAR(overlap(a, b).value() / expected, 1.0, 1e-12) << d;  // measured 2e-15
  }
}

TEST(GaussianOverlap, HasTheClosedFormsOfSevenDimensions) {
  const VectorXd m = Random(3).numbers(7);
  VectorXd far = m;
  far[2] += 3.0;
  const auto of = [&](const VectorXd& centre, double sa, double sb) {
    return overlap(unit(m, sa), unit(centre, sb)).value();
  };
  // equal: (pi s^2)^(d/2); one far wider: the integral of the narrow one; apart: a factor exp(-D^2/(4 s^2))
  EXPECT_NEAR(of(m, 0.7, 0.7) / std::pow(pi * 0.49, 3.5), 1.0, 1e-14);
  EXPECT_NEAR(of(m, 0.7, 1e9) / std::pow(2.0 * pi * 0.49, 3.5), 1.0, 1e-13);
  EXPECT_NEAR(of(far, 0.7, 0.7) / of(m, 0.7, 0.7), std::exp(-9.0 / 1.96), 1e-15);
}

TEST(GaussianOverlap, KeepsItsLogarithmWhereItsValueLeavesTheRange) {
  const VectorXd m = VectorXd::Zero(20000);
  const GaussianSum wide = unit(m, 10.0), narrow = unit(m, 0.01);
  const ScaledValue large = overlap(wide, wide), small = overlap(narrow, narrow);
  EXPECT_NEAR(large.log_scale, 1e4 * std::log(100.0 * pi), 1e-9);
  EXPECT_NEAR(small.log_scale, 1e4 * std::log(1e-4 * pi), 1e-9);
  EXPECT_EQ(large.value(), std::numeric_limits<double>::infinity());
  EXPECT_EQ(small.value(), 0.0);
  // the cosine of the angle between both functions is an ordinary number: (2 s_a s_b/S)^(d/2)
  const GaussianSum other = unit(m, 10.1);
  const double cosine =
      std::exp(overlap(wide, other).log_scale - 0.5 * (large.log_scale + overlap(other, other).log_scale));
  EXPECT_NEAR(cosine / std::pow(2.0 * 10.0 * 10.1 / (100.0 + 102.01), 1e4), 1.0, 1e-10);
}

// A far larger overlap that counts nothing must not hide what the sum has.
TEST(GaussianOverlap, TakesItsScaleFromTermsOfWeight) {
  GaussianSum a(1);
  a.add(0.0, VectorXd::Zero(1), 1.0);
  a.add(1.0, VectorXd::Constant(1, 60.0), 1.0);
  const GaussianSum b = unit(VectorXd::Zero(1), 1.0);
  const ScaledValue value = overlap(a, b);
  EXPECT_EQ(value.mantissa, 1.0);
  EXPECT_NEAR(value.log_scale, 0.5 * std::log(pi) - 900.0, 1e-10);
  const ScaledValue other = overlap(b, a);
  EXPECT_EQ(other.mantissa, 1.0);
  EXPECT_NEAR(other.log_scale, value.log_scale, 1e-10);
  // the derivative by the weight 0 is the larger number, and there
  VectorXd gradient;
  const ScaledValue scaled = overlap(a, b, &gradient);
  EXPECT_NEAR(gradient[0] * std::exp(scaled.log_scale) / std::sqrt(pi), 1.0, 1e-14);
  // nothing at all
  GaussianSum none(1);
  none.add(0.0, VectorXd::Zero(1), 1.0);
  EXPECT_EQ(overlap(none, b).value(), 0.0);
}

TEST(GaussianOverlap, IsNeverNaN) {
  const VectorXd origin = VectorXd::Zero(3), far = VectorXd::Constant(3, 1e300);
  const double least = std::exp(-299.0), most = std::exp(299.0);
  for (const double a : {least, 1.0, most})
    for (const double b : {least, 1.0, most})
      for (const VectorXd& centre : {origin, far}) {
        VectorXd gradient;
        const ScaledValue value = overlap(unit(origin, a), unit(centre, b), &gradient);
        EXPECT_FALSE(std::isnan(value.value()));
        EXPECT_TRUE(gradient.allFinite());
        VectorXd derivatives(5);
        EXPECT_TRUE(std::isfinite(evaluate(unit(centre, a), origin, derivatives.data())));
        EXPECT_TRUE(derivatives.allFinite());
      }
}

TEST(GaussianGradient, OfTheLogarithmOfAnOverlapEqualsDifferences) {
  for (const int d : {1, 3, 7}) {
    Random random(d);
    const VectorXd at = random.numbers(2 * d + 2);
    const auto log_value = [&](const VectorXd& p) {
      return overlap(p.head(d), p[2 * d], p.segment(d, d), p[2 * d + 1]).log_value;
    };
    const GaussianOverlap o = overlap(at.head(d), at[2 * d], at.segment(d, d), at[2 * d + 1]);
    VectorXd gradient(2 * d + 2);
    gradient << o.by_centre_a, -o.by_centre_a, o.by_log_width_a, o.by_log_width_b;
    const VectorXd expected = finite_gradient(log_value, at, 1e-3);
    ASSERT_GT(expected.norm(), 0.1);
    EXPECT_LT((gradient - expected).norm() / expected.norm(), 1e-10) << d;  // measured 4e-13
  }
}

TEST(GaussianGradient, OfTheOverlapOfSumsEqualsDifferences) {
  const GaussianSum a = random_sum(7, 3, 3), b = random_sum(8, 3, 2);
  VectorXd gradient;
  const ScaledValue value = overlap(a, b, &gradient);
  gradient *= std::exp(value.log_scale);
  const VectorXd expected = finite_gradient(
      [&](const VectorXd& p) {
        GaussianSum moved = a;
        moved.parameters = p;
        return overlap(moved, b).value();
      },
      a.parameters, 1e-3);
  ASSERT_GT(expected.norm(), 0.1);
  EXPECT_LT((gradient - expected).norm() / expected.norm(), 1e-10);  // measured 9e-13
}

TEST(GaussianGradient, OfAValueEqualsDifferences) {
  for (const int d : {1, 2, 5}) {
    const GaussianSum sum = random_sum(9, d, 3);
    const VectorXd x = Random(4).numbers(d);
    VectorXd gradient(sum.parameters.size());
    evaluate(sum, x, gradient.data());
    const VectorXd expected = finite_gradient(
        [&](const VectorXd& p) {
          GaussianSum moved = sum;
          moved.parameters = p;
          return evaluate(moved, x);
        },
        sum.parameters, 1e-3);
    ASSERT_GT(expected.norm(), 0.1);
    EXPECT_LT((gradient - expected).norm() / expected.norm(), 1e-10) << d;  // measured 3e-12
  }
}

// Samples of a sum at random points of [-2, 2]^d, with noise, and a start beside it.
struct FitProblem {
  GaussianSum known, start;
  Eigen::MatrixXd points;
  VectorXd values;

  FitProblem(std::uint64_t seed, int dimension, int gaussians, int count, double noise)
      : known(random_sum(seed, dimension, gaussians)), start(known) {
    Random random(seed + 100);
    points.resize(dimension, count);
    values.resize(count);
    for (int i = 0; i < count; ++i) {
      points.col(i) = random.numbers(dimension, 2.0);
      values[i] = evaluate(known, points.col(i)) + noise * random.uniform();
    }
    start.parameters += random.numbers(static_cast<int>(start.parameters.size()), 0.15);
  }
  // J^T r, anew
  VectorXd gradient(const GaussianSum& at, double& residual, double& rows) const {
    VectorXd sum = VectorXd::Zero(at.parameters.size()), row(at.parameters.size());
    residual = rows = 0.0;
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      const double r = evaluate(at, points.col(i), row.data()) - values[i];
      sum += r * row;
      residual += r * r;
      rows += row.squaredNorm();
    }
    residual = std::sqrt(residual), rows = std::sqrt(rows);
    return sum;
  }
};

TEST(GaussianFit, RecoversAKnownSumFromExactSamples) {
  for (const FitRoute route : {FitRoute::kAuto, FitRoute::kPrimal, FitRoute::kDual})
    for (int d = 1; d <= 3; ++d) {
      const FitProblem problem(20, d, 2, 60, 0.0);
      GaussianSum sum = problem.start;
      ASSERT_GT((sum.parameters - problem.known.parameters).norm(), 0.1);
      const GaussianFit fit = fit_gaussians(problem.points, problem.values, sum, {.route = route});
      ASSERT_TRUE(fit.status.ok()) << fit.status.reason;
      EXPECT_LT((sum.parameters - problem.known.parameters).norm(), 1e-8) << d;  // measured 1e-15
    }
}

TEST(GaussianFit, EndsAtAStationaryPointUnderNoise) {
  for (int d = 1; d <= 3; ++d) {
    const FitProblem problem(30, d, 2, 200, 0.05);
    GaussianSum sum = problem.start;
    double residual, rows;
    ASSERT_GT(problem.gradient(sum, residual, rows).norm(), 1e-2 * residual * rows);
    const GaussianFit fit = fit_gaussians(problem.points, problem.values, sum);
    ASSERT_TRUE(fit.status.ok()) << fit.status.reason;
    const double left = problem.gradient(sum, residual, rows).norm();
    EXPECT_GT(fit.rms, 0.02);
    EXPECT_LT(left, 1e-9 * residual * rows) << d;  // measured 3e-11
  }
}

TEST(GaussianFit, ConvergesQuadraticallyWhereTheResidualVanishes) {
  const FitProblem problem(20, 2, 2, 60, 0.0);
  GaussianSum sum = problem.start;
  const GaussianFit fit = fit_gaussians(problem.points, problem.values, sum);
  ASSERT_TRUE(fit.status.ok()) << fit.status.reason;
  // the last three norms above rounding
  int last = static_cast<int>(fit.residual_norms.size()) - 1;
  while (fit.residual_norms[last] < 1e-13 * problem.values.norm()) --last;
  ASSERT_GE(last, 2);
  const auto r = fit.residual_norms;
  const double order = std::log(r[last] / r[last - 1]) / std::log(r[last - 1] / r[last - 2]);
  EXPECT_GT(order, 1.8);  // measured 2.25
  EXPECT_LT(r[last], 1e-7 * problem.values.norm());
}

TEST(GaussianFit, BothRoutesTakeTheSameSteps) {
  const FitProblem problem(40, 2, 2, 12, 0.05);
  GaussianSum primal = problem.start, dual = problem.start;
  const GaussianFit one = fit_gaussians(problem.points, problem.values, primal,
                                        {.route = FitRoute::kPrimal, .most_steps = 5, .first_damping = 10.0}),
                    two = fit_gaussians(problem.points, problem.values, dual,
                                        {.route = FitRoute::kDual, .most_steps = 5, .first_damping = 10.0});
  ASSERT_GE(one.steps, 3);
  ASSERT_GT((primal.parameters - problem.start.parameters).norm(), 0.05);
  EXPECT_TRUE(one.primal);
  EXPECT_FALSE(two.primal);
  EXPECT_EQ(one.steps, two.steps);
  EXPECT_LT((primal.parameters - dual.parameters).norm(), 1e-12);  // measured 8e-16
}

TEST(GaussianFit, FewerPointsThanParametersAreMetExactly) {
  for (const int points : {3, 6})
    for (const FitRoute route : {FitRoute::kAuto, FitRoute::kPrimal, FitRoute::kDual}) {
      const FitProblem problem(50, 3, 3, points, 0.3);
      GaussianSum sum = problem.start;
      const GaussianFit fit = fit_gaussians(problem.points, problem.values, sum, {.route = route});
      ASSERT_TRUE(fit.status.ok()) << fit.status.reason;
      if (route == FitRoute::kAuto) EXPECT_EQ(fit.primal, points == 6);  // of 15 parameters
      ASSERT_GT(fit.residual_norms[0], 0.1);
      EXPECT_LT(fit.rms, 1e-12);  // measured 3e-16
    }
}

TEST(GaussianFit, StatesThatItHasNotConverged) {
  const FitProblem problem(20, 2, 2, 60, 0.0);
  GaussianSum sum = problem.start;
  const GaussianFit fit = fit_gaussians(problem.points, problem.values, sum, {.most_steps = 2});
  EXPECT_EQ(fit.status.code, StatusCode::kNotConverged);
  EXPECT_NE(fit.status.reason.find("2 steps"), std::string::npos) << fit.status.reason;
  EXPECT_GT(fit.gradient, 1e-10);
}

TEST(GaussianFit, IsNeverNaNFromBadStarts) {
  // far starts, equal Gaussians (dependent parameters), tiny and huge widths, constant and zero values
  Random random(60);
  int converged = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const int d = 1 + trial % 3, count = 1 + random.below(3), n = 1 + random.below(40);
    GaussianSum sum(d);
    for (int k = 0; k < count; ++k)
      sum.add(random.uniform(-1.0, 1.0), trial % 5 == 0 ? VectorXd::Zero(d) : random.numbers(d, 5.0),
              std::exp(trial % 5 == 0 ? 0.0 : random.uniform(-9.0, 9.0)));
    Eigen::MatrixXd points(d, n);
    VectorXd values = trial % 7 == 0 ? VectorXd::Constant(n, trial % 2) : random.numbers(n, 3.0);
    for (int i = 0; i < n; ++i) points.col(i) = random.numbers(d, 2.0);
    const GaussianFit fit = fit_gaussians(points, values, sum, {.most_steps = 100});
    converged += fit.status.ok();
    EXPECT_TRUE(in_range(sum)) << trial;
    EXPECT_TRUE(std::isfinite(fit.rms) && std::isfinite(fit.gradient)) << trial;
    EXPECT_LE(fit.residual_norms.tail(1)[0], fit.residual_norms[0] * (1.0 + 1e-12)) << trial;
    EXPECT_TRUE(fit.status.ok() || !fit.status.reason.empty());
  }
  EXPECT_GT(converged, 20);  // measured 64 of 200
}

TEST(GaussianFit, AStartWhoseSquaresOverflowIsNotFinite) {
  GaussianSum sum(1);
  sum.add(1e200, VectorXd::Zero(1), 1.0);
  const GaussianFit fit = fit_gaussians(Eigen::MatrixXd::Zero(1, 1), VectorXd::Zero(1), sum);
  EXPECT_EQ(fit.status.code, StatusCode::kNonFinite);
}

TEST(GaussianFit, RefusesBadInput) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  GaussianSum sum(2), empty(2);
  sum.add(1.0, VectorXd::Zero(2), 1.0);
  const Eigen::MatrixXd points = Eigen::MatrixXd::Zero(2, 3);
  const VectorXd values = VectorXd::Ones(3);
  const auto fit = [&](const Eigen::MatrixXd& x, const VectorXd& f, GaussianSum s,
                       const GaussianFitOptions& options = {}) {
    return [=]() mutable { fit_gaussians(x, f, s, options); };
  };
  EXPECT_TRUE(test::refused("points = 0", fit(Eigen::MatrixXd(2, 0), VectorXd(), sum)));
  EXPECT_TRUE(test::refused("points = 3", fit(points, VectorXd::Ones(2), sum)));
  EXPECT_TRUE(test::refused("dimension of the points = 1", fit(Eigen::MatrixXd::Zero(1, 3), values, sum)));
  EXPECT_TRUE(test::refused("point = nan", fit(Eigen::MatrixXd::Constant(2, 3, nan), values, sum)));
  EXPECT_TRUE(test::refused("value = nan", fit(points, VectorXd::Constant(3, nan), sum)));
  EXPECT_TRUE(test::refused("Gaussians = 0", fit(points, values, empty)));
  EXPECT_TRUE(test::refused("first damping = 0", fit(points, values, sum, {.first_damping = 0.0})));
  EXPECT_TRUE(test::refused("tolerance = -1", fit(points, values, sum, {.tolerance = -1.0})));
  EXPECT_TRUE(test::refused("most steps = 0", fit(points, values, sum, {.most_steps = 0})));
  GaussianSum wild = sum;
  wild.parameters[3] = 400.0;
  EXPECT_TRUE(test::refused("out of range", fit(points, values, wild)));
  EXPECT_TRUE(test::refused("dimension = 0", [] { GaussianSum(0); }));
  EXPECT_TRUE(test::refused("width = 0", [&] { empty.add(1.0, VectorXd::Zero(2), 0.0); }));
  EXPECT_TRUE(test::refused("width = -1", [&] { empty.add(1.0, VectorXd::Zero(2), -1.0); }));
  EXPECT_TRUE(test::refused("expected a size within exp", [&] { empty.add(1.0, VectorXd::Zero(2), 1e200); }));
  EXPECT_TRUE(test::refused("weight = nan", [&] { empty.add(nan, VectorXd::Zero(2), 1.0); }));
  EXPECT_TRUE(test::refused("centre = nan", [&] { empty.add(1.0, VectorXd::Constant(2, nan), 1.0); }));
  EXPECT_TRUE(test::refused("numbers of the centre = 3", [&] { empty.add(1.0, VectorXd::Zero(3), 1.0); }));
}

}  // namespace
}  // namespace feder
