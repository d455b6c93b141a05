// Sweeps over the rows of a step: their rate against the predicted one (notes H3), the projections of notes
// H1, H2, H4 and H5.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "solvers/step_row_solver.h"
#include "tests/solvers/random_step_rows.h"

namespace feder {
namespace {

using Eigen::MatrixXd;
using test::random_rows;
using Problem = test::StepRowProblem;

// ---- Kaczmarz (H3)

// Largest |eigenvalue| of -(D + L)^-1 U.
double spectral_radius(const MatrixXd& S) {
  const MatrixXd lower = S.triangularView<Eigen::Lower>(), upper = S.triangularView<Eigen::StrictlyUpper>();
  return Eigen::EigenSolver<MatrixXd>(lower.partialPivLu().solve(upper)).eigenvalues().cwiseAbs().maxCoeff();
}

// Factor by which a sweep shrinks the error in the end. With r = 0 and v = W J^T y the solution is 0; every
// few sweeps y is scaled up again, so that no rounding hides how the error goes on to fall.
double measured_rate(Problem p) {
  constexpr int kSweeps = 4, kBlocks = 2000;
  p.rows.r.setZero();
  VectorXd y = Random(5).numbers(p.rows.count());
  double log_fall = 0.0;
  for (int block = 0; block < kBlocks; ++block) {
    y /= y.norm();
    p.v.setZero();
    for (int k = 0; k < p.rows.count(); ++k) p.rows.push_row(k, y[k], p.inverse_mass.data(), p.v.data());
    for (int i = 0; i < kSweeps; ++i) sweep_step_rows(p.rows, p.inverse_mass, p.v, y);
    if (block >= kBlocks / 2) log_fall += std::log(y.norm());
  }
  return std::exp(log_fall / (kSweeps * (kBlocks / 2)));
}

// A straight chain of equal links that hangs on a fixed node.
Problem chain(int links) {
  Problem p;
  p.inverse_mass = VectorXd::Ones(links + 1);
  p.inverse_mass[0] = 0.0;
  p.v = Random(1).numbers(links + 1);
  p.v[0] = 0.0;
  for (int k = 0; k < links; ++k) {
    p.rows.add(k, -1.0);
    p.rows.add(k + 1, 1.0);
    p.rows.close_row();
  }
  p.rows.gamma = p.rows.r = VectorXd::Zero(links);
  return p;
}

// Distance rows of random directions between random particles.
Problem net(std::uint64_t seed, int particles, int links, double gamma) {
  Random random(seed);
  Problem p;
  for (int k = 0; k < links; ++k) {
    const int a = random.below(particles), b = (a + 1 + random.below(particles - 1)) % particles;
    const Vector3d u = random.vector().normalized();
    for (int c = 0; c < 3; ++c) p.rows.add(3 * a + c, -u[c]);
    for (int c = 0; c < 3; ++c) p.rows.add(3 * b + c, u[c]);
    p.rows.close_row();
  }
  p.inverse_mass.resize(3 * particles);
  for (int i = 0; i < particles; ++i) p.inverse_mass.segment<3>(3 * i).setConstant(random.uniform(0.2, 5.0));
  p.v = random.numbers(3 * particles);
  p.rows.r = random.numbers(links);
  p.rows.gamma = VectorXd::Constant(links, gamma);
  return p;
}

TEST(Kaczmarz, RateOnAChainIsThatOfGaussSeidel) {
  for (const int links : {5, 10, 20}) {
    const double closed = std::pow(std::cos(std::numbers::pi / (2 * links)), 2);
    const double radius = spectral_radius(chain(links).schur());
    EXPECT_NEAR(radius, closed, 1e-10);
    EXPECT_NEAR(std::log(measured_rate(chain(links))) / std::log(radius), 1.0,
                0.02);  // measured off by 1e-13
  }
}

TEST(Kaczmarz, RateOnRandomNetsIsThatOfGaussSeidel) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed)
    for (const double gamma : {0.0, 0.3}) {
      const Problem p = net(seed, 20, 45, gamma);
      const double radius = spectral_radius(p.schur());
      ASSERT_LT(radius, 1.0);
      EXPECT_NEAR(std::log(measured_rate(p)) / std::log(radius), 1.0, 0.02) << seed;  // measured off by 6e-4
    }
}

TEST(Kaczmarz, ALongChainShowsWhatTheDirectSolveSaves) {
  Problem p = chain(100);
  VectorXd v = p.v, y;
  const double start = p.residual(v, VectorXd::Zero(100)).norm();
  ASSERT_TRUE(StepRowSolver().solve(p.rows, p.inverse_mass, v, y).ok());
  EXPECT_LT(p.residual(v, y).norm(), 1e-13 * start);  // measured 3e-16
  y.setZero();
  for (int i = 0; i < 1000; ++i) sweep_step_rows(p.rows, p.inverse_mass, p.v, y);
  EXPECT_GT(p.residual(p.v, y).norm(), 1e-5 * start);  // measured 6e-4
}

// ---- Projections (H1, H2, H4, H5)

// The distance constraint C = |p1 - p2| - d of two particles, linearised at p: J = (n, -n).
struct Pair {
  Vector3d p1{0.3, -0.2, 0.5}, p2{-0.4, 0.6, 0.1};
  double d = 0.7, m1 = 2.0, m2 = 5.0;

  double C(const VectorXd& move) const { return (p1 + move.head<3>() - p2 - move.tail<3>()).norm() - d; }
  Problem problem(bool weighted) const {
    Problem p;
    const Vector3d n = (p1 - p2).normalized();
    for (int c = 0; c < 6; ++c) p.rows.add(c, c < 3 ? n[c] : -n[c - 3]);
    p.rows.close_row();
    p.v = VectorXd::Zero(6);
    p.inverse_mass = VectorXd::Ones(6);
    if (weighted) p.inverse_mass << Vector3d::Constant(1.0 / m1), Vector3d::Constant(1.0 / m2);
    p.rows.r = VectorXd::Constant(1, C(p.v));
    p.rows.gamma = VectorXd::Zero(1);
    return p;
  }
  VectorXd project(bool weighted, RowWeights weights = RowWeights::kMass) const {
    Problem p = problem(weighted);
    VectorXd y = VectorXd::Zero(1);
    sweep_step_rows(p.rows, p.inverse_mass, p.v, y, weights);
    return p.v;
  }
  double centre_shift(const VectorXd& move) const {
    return (m1 * move.head<3>() + m2 * move.tail<3>()).norm() / (m1 + m2);
  }
};

TEST(H1, TheLinearisedDistanceHasAQuadraticRemainder) {
  const Pair pair;
  const Problem p = pair.problem(false);
  const VectorXd direction = Random(2).numbers(6, 0.1);
  const auto remainder = [&](double t) {
    return std::abs(pair.C(t * direction) - pair.C(p.v) - t * (p.jacobian() * direction)[0]);
  };
  ASSERT_GT(remainder(0.1), 1e-6);
  EXPECT_NEAR(std::log2(remainder(0.1) / remainder(0.05)), 2.0, 0.02);  // measured off by 0.004
}

TEST(H2, OneProjectionMeetsALinearRow) {
  Problem p = random_rows(3, 1, 12, 8, 0.0);
  p.inverse_mass.setOnes();
  VectorXd y = VectorXd::Zero(1);
  const VectorXd start = p.v, J = p.jacobian().transpose();
  const double before = p.residual(p.v, y)[0];
  ASSERT_GT(std::abs(before), 0.1);
  sweep_step_rows(p.rows, p.inverse_mass, p.v, y);
  EXPECT_LT(std::abs(p.residual(p.v, y)[0]), 1e-14);  // measured 4e-16
  // dp = -C grad C / |grad C|^2
  EXPECT_LT((p.v - start + before / J.squaredNorm() * J).norm(), 1e-14);
}

TEST(H4, WithoutWeightsTheDistanceIsMetAndTheCentreOfMassMoves) {
  const Pair pair;
  const VectorXd move = pair.project(false);
  ASSERT_GT(pair.C(VectorXd::Zero(6)), 0.3);
  EXPECT_LT(std::abs(pair.C(move)), 1e-15);
  const Vector3d n = (pair.p1 - pair.p2).normalized();
  const double half = 0.5 * pair.C(VectorXd::Zero(6));
  EXPECT_LT((move.head<3>() + half * n).norm() + (move.tail<3>() - half * n).norm(), 1e-15);
  EXPECT_GT(pair.centre_shift(move), 0.01);
  // equal masses: it stays
  Pair equal = pair;
  equal.m2 = equal.m1;
  EXPECT_LT(equal.centre_shift(equal.project(false)), 1e-16);
}

TEST(H5, MassWeightsMeetTheDistanceAndKeepTheCentreOfMass) {
  const Pair pair;
  const VectorXd move = pair.project(true);
  ASSERT_GT(move.norm(), 0.1);
  EXPECT_LT(std::abs(pair.C(move)), 1e-15);
  EXPECT_LT(pair.centre_shift(move), 1e-16);
}

TEST(H5, TheHalvedWeightsAsPrintedLeaveHalfTheViolation) {
  const Pair pair;
  const double before = pair.C(VectorXd::Zero(6));
  const VectorXd move = pair.project(true, RowWeights::kHalved);
  EXPECT_NEAR(pair.C(move) / before, 0.5, 1e-15);
  EXPECT_LT(pair.centre_shift(move), 1e-16);
}

}  // namespace
}  // namespace feder
