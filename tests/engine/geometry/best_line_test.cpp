// Best line, covariance and gradients (notes A5, A6, A8, C5).
#include "engine/geometry/best_line.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "engine/check.h"
#include "engine/mass_properties.h"
#include "tests/support/random.h"

namespace feder {
namespace {

/// A stretched and turned cloud about a mean of its own.
std::vector<Vector3d> cloud(Random& random, int count) {
  const Vector3d stretch(random.uniform(1.0, 3.0), random.uniform(0.5, 1.0), random.uniform(0.1, 0.5));
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(random.uniform(-3.0, 3.0), random.vector().normalized()));
  const Vector3d shift = random.vector(5.0);
  std::vector<Vector3d> points;
  for (int i = 0; i < count; ++i) points.push_back(turn * random.vector().cwiseProduct(stretch) + shift);
  return points;
}

double squared_distance(const std::vector<Vector3d>& points, const Vector3d& mean, const Vector3d& v) {
  double sum = 0.0;
  for (const Vector3d& p : points) sum += (p - mean).cross(v).squaredNorm();
  return sum;
}

TEST(BestLine, SquaredCrossProductIsProductOfSquaresMinusSquareOfProduct) {
  Random random(1);
  double worst = 0.0, worst_printed = 0.0, largest_product = 0.0;
  for (int trial = 0; trial < 1000; ++trial) {
    const Vector3d p = random.vector().normalized(), v = random.vector().normalized();
    const double left = p.cross(v).squaredNorm(), squares = p.squaredNorm() * v.squaredNorm(), pv = p.dot(v);
    worst = std::max(worst, std::abs(left - (squares - pv * pv)));
    // as printed in the second line of L(v), + sum v^T p p^T v: off by twice that
    worst_printed = std::max(worst_printed, std::abs(left - (squares + pv * pv) + 2.0 * pv * pv));
    largest_product = std::max(largest_product, pv * pv);
  }
  EXPECT_LT(worst, 1e-15);          // 6e-16
  EXPECT_LT(worst_printed, 1e-15);  // 7e-16
  EXPECT_GT(largest_product, 0.9);
}

TEST(BestLine, ThePrintedSignTurnsTheBestLineIntoTheWorst) {
  Random random(2);
  const std::vector<Vector3d> points = cloud(random, 50);
  const Spread spread = point_spread(points);
  const Matrix3d E = Matrix3d::Identity();
  const Matrix3d corrected = spread.covariance.trace() * E - spread.covariance;
  const Matrix3d printed = spread.covariance.trace() * E + spread.covariance;
  const Vector3d best = Eigen::SelfAdjointEigenSolver<Matrix3d>(corrected).eigenvectors().col(0);
  const Vector3d other = Eigen::SelfAdjointEigenSolver<Matrix3d>(printed).eigenvectors().col(0);
  const Vector3d found = best_line(points).direction;
  EXPECT_LT(found.cross(best).norm(), 1e-14);  // 1e-16
  EXPECT_GT(squared_distance(points, spread.mean, other), 2.0 * squared_distance(points, spread.mean, found));
}

TEST(BestLine, CrossProductsMultiplyLikeADeterminant) {
  Random random(3);
  double worst = 0.0;
  for (int trial = 0; trial < 1000; ++trial) {
    const Vector3d a = random.vector().normalized(), b = random.vector().normalized();
    const Vector3d c = random.vector().normalized(), d = random.vector().normalized();
    const double expected = a.dot(c) * b.dot(d) - a.dot(d) * b.dot(c);
    worst = std::max(worst, std::abs(a.cross(b).dot(c.cross(d)) - expected));
  }
  EXPECT_LT(worst, 1e-15);  // 2e-16
}

TEST(BestLine, SatisfiesTheMultiplierCondition) {
  Random random(4);
  for (int trial = 0; trial < 200; ++trial) {
    const std::vector<Vector3d> points = cloud(random, 30);
    const Matrix3d C = point_spread(points).covariance;
    const Matrix3d axes = critical_axes(C).axes;
    EXPECT_LT((axes.transpose() * axes - Matrix3d::Identity()).norm(), 1e-12);  // 2e-15
    EXPECT_GT(axes.determinant(), 0.0);
    for (int k = 0; k < 3; ++k) {
      const Vector3d v = axes.col(k);
      const double lambda = v.dot(C * v);
      EXPECT_LT((C * v - lambda * v).norm() / C.norm(), 1e-14);  // 1.3e-15
    }
  }
}

TEST(BestLine, LeavesTheSquaresMinusTheLargestEigenvalue) {
  Random random(5);
  for (int trial = 0; trial < 200; ++trial) {
    const std::vector<Vector3d> points = cloud(random, 30);
    const Spread spread = point_spread(points);
    const CriticalAxes critical = critical_axes(spread.covariance);
    const double scale = spread.covariance.trace();
    for (int k = 0; k < 3; ++k) {
      const double sum = squared_distance(points, spread.mean, critical.axes.col(k));
      EXPECT_LT(std::abs(critical.squared_distance[k] - sum) / scale, 1e-14);  // 1.3e-15
    }
    // no direction and no other point does better
    const Line line = best_line(points);
    const double least = squared_distance(points, line.point, line.direction);
    for (int other = 0; other < 20; ++other) {
      const Vector3d v = random.vector().normalized(), shift = random.vector();
      EXPECT_GE(squared_distance(points, line.point, v), least * (1.0 - 1e-13));
      EXPECT_GE(squared_distance(points, line.point + shift, line.direction), least * (1.0 - 1e-13));
    }
  }
}

TEST(CriticalAxes, AreOneMinimumOneSaddleAndOneMaximum) {
  Random random(6);
  for (int trial = 0; trial < 200; ++trial) {
    SCOPED_TRACE(trial);
    const std::vector<Vector3d> points = cloud(random, 200);
    const Spread spread = point_spread(points);
    const CriticalAxes critical = critical_axes(spread.covariance);

    // second differences of sum |p x v|^2 itself, turning from axis i towards axis j
    int rising[3] = {};
    for (int i = 0; i < 3; ++i)
      for (int j : {(i + 1) % 3, (i + 2) % 3}) {
        const double h = 0.1;
        const Vector3d v = critical.axes.col(i), w = critical.axes.col(j);
        const double ahead = squared_distance(points, spread.mean, std::cos(h) * v + std::sin(h) * w);
        const double behind = squared_distance(points, spread.mean, std::cos(h) * v - std::sin(h) * w);
        const double second_difference = ahead - 2.0 * squared_distance(points, spread.mean, v) + behind;
        ASSERT_GT(std::abs(second_difference), 1e-6 * spread.covariance.trace());
        rising[i] += second_difference > 0.0;
      }
    EXPECT_EQ(rising[0], 2);
    EXPECT_EQ(rising[1], 1);
    EXPECT_EQ(rising[2], 0);
    EXPECT_EQ(critical.kind[0], AxisKind::kMinimum);
    EXPECT_EQ(critical.kind[1], AxisKind::kSaddle);
    EXPECT_EQ(critical.kind[2], AxisKind::kMaximum);
  }
}

TEST(CriticalAxes, SayWhereAnAxisIsOneOfMany) {
  const auto kinds = [](double x, double y, double z) {
    return critical_axes(Vector3d(x, y, z).asDiagonal()).kind;
  };
  using enum AxisKind;
  EXPECT_EQ(kinds(3, 1, 1), (std::array{kMinimum, kDegenerate, kDegenerate}));
  EXPECT_EQ(kinds(2, 2, 1), (std::array{kDegenerate, kDegenerate, kMaximum}));
  EXPECT_EQ(kinds(1, 1, 1), (std::array{kDegenerate, kDegenerate, kDegenerate}));
  EXPECT_EQ(kinds(0, 0, 0), (std::array{kDegenerate, kDegenerate, kDegenerate}));
}

TEST(Covariance, DoesNotSeeWhereTheWorldsOriginIs) {
  Random random(7);
  std::vector<Vector3d> points = cloud(random, 40), far = points;
  for (Vector3d& p : points) p = (p.array() + 64.0) - 64.0;  // on a grid the shift below is exact for
  far = points;
  for (Vector3d& p : far) p += Vector3d(1024, -2048, 512);
  const Matrix3d here = point_spread(points).covariance, there = point_spread(far).covariance;
  // about the origin, without centring, the covariance is a different one
  Matrix3d raw = Matrix3d::Zero();
  for (const Vector3d& p : far) raw += p * p.transpose();
  EXPECT_LT((here - there).norm() / here.norm(), 1e-12);  // 3e-14: of the far mean
  EXPECT_GT((raw - here).norm() / here.norm(), 1e4);      // 2e6
}

TEST(Covariance, HasTheEigenvectorsOfTheInertia) {
  Random random(8);
  for (int trial = 0; trial < 100; ++trial) {
    std::vector<PointMass> masses;
    std::vector<Vector3d> points = cloud(random, 20);
    for (const Vector3d& p : points) masses.push_back({1.0, p});
    const Spread spread = point_spread(points);
    const MassProperties body = point_masses("cloud", masses);
    const CriticalAxes critical = critical_axes(spread.covariance);
    const PrincipalAxes principal = principal_axes(body);

    // eigenvalues tr(C) - lambda are the sums of squared distances: same vectors, order reversed
    const double apart = (covariance_from_inertia(body.inertia) - spread.covariance).norm();
    EXPECT_LT(apart / spread.covariance.norm(), 1e-13);  // 5e-16
    for (int k = 0; k < 3; ++k) {
      EXPECT_LT(principal.axes.col(k).cross(critical.axes.col(k)).norm(), 1e-12);  // 9e-15
      EXPECT_LT(std::abs(principal.moments[k] - critical.squared_distance[k]) / principal.moments[2],
                1e-13);  // 1.5e-15
    }
  }
}

TEST(Covariance, OfASurfaceDoesNotDependOnHowItIsCut) {
  // a 4 x 2 rectangle as two triangles, then with one half cut into 4^5 pieces
  TriangleMesh coarse{{{0, 0, 0}, {4, 0, 0}, {4, 2, 0}, {0, 2, 0}}, {{0, 1, 2}, {0, 2, 3}}};
  TriangleMesh fine = coarse;
  std::vector<std::array<int, 3>> pieces = {fine.triangles[1]};
  for (int level = 0; level < 5; ++level) {
    std::vector<std::array<int, 3>> finer;
    for (const auto& [a, b, c] : pieces) {
      const int m = static_cast<int>(fine.vertices.size());
      fine.vertices.push_back(0.5 * (fine.vertices[a] + fine.vertices[b]));
      fine.vertices.push_back(0.5 * (fine.vertices[b] + fine.vertices[c]));
      fine.vertices.push_back(0.5 * (fine.vertices[c] + fine.vertices[a]));
      finer.insert(finer.end(), {{a, m, m + 2}, {m, b, m + 1}, {m + 2, m + 1, c}, {m, m + 1, m + 2}});
    }
    pieces = finer;
  }
  fine.triangles = pieces;
  fine.triangles.push_back(coarse.triangles[0]);

  const Spread a = surface_spread(coarse), b = surface_spread(fine);
  EXPECT_NEAR(a.weight, 8.0, 1e-15);
  EXPECT_NEAR(b.weight, 8.0, 1e-13);                          // 0
  EXPECT_LT((a.mean - Vector3d(2, 1, 0)).norm(), 1e-15);      // 0
  EXPECT_LT((b.mean - a.mean).norm(), 1e-13);                 // 1e-15
  EXPECT_LT((b.covariance - a.covariance).norm(), 1e-12);     // 9e-15
  EXPECT_NEAR(a.covariance(0, 0), 8.0 * 16.0 / 12.0, 1e-14);  // S l^2 / 12
  EXPECT_NEAR(a.covariance(1, 1), 8.0 * 4.0 / 12.0, 1e-14);
  EXPECT_NEAR(a.covariance(0, 1), 0.0, 1e-14);

  // the points lie dense in one half and drag the mean there
  EXPECT_GT((point_spread(fine.vertices).mean - a.mean).norm(), 0.5);
}

TEST(Covariance, RefusesWhatIsNotFiniteOrEmpty) {
  EXPECT_THROW((void)point_spread({}), MisuseError);
  EXPECT_THROW((void)surface_spread(TriangleMesh{}), MisuseError);
  const std::vector<Vector3d> bad = {{0, 0, 0}, {INFINITY, 0, 0}};
  EXPECT_THROW((void)point_spread(bad), MisuseError);
  EXPECT_THROW((void)critical_axes(Matrix3d::Constant(NAN)), MisuseError);
}

TEST(QuadraticForm, HasTheGradientAPlusItsTransposeTimesX) {
  Random random(9);
  for (int d : {3, 7}) {
    const Eigen::MatrixXd A = random.numbers(d * d).reshaped(d, d);
    const VectorXd x = random.numbers(d);
    ASSERT_GT((A - A.transpose()).norm(), 0.5);
    VectorXd difference(d);
    const double h = 1e-3;  // central differences are exact for a quadratic form
    for (int i = 0; i < d; ++i) {
      const VectorXd step = h * VectorXd::Unit(d, i);
      difference[i] = ((x + step).dot(A * (x + step)) - (x - step).dot(A * (x - step))) / (2.0 * h);
    }
    EXPECT_LT((difference - (A + A.transpose()) * x).norm(), 1e-11);  // 3e-13
    EXPECT_GT((difference - 2.0 * A * x).norm(), 0.1);                // for symmetric A alone
  }
}

}  // namespace
}  // namespace feder
