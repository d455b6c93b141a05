// The residual of the step matrix against a dense computation that shares nothing with the engine.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <string>

#include "engine/kkt.h"
#include "tests/support/dense_kkt.h"
#include "tests/support/kernel_choice.h"
#include "tests/support/scenes.h"

namespace feder {
namespace {

using Eigen::MatrixXd;

constexpr double kSigma = 0.04, kRho = 0.2;

struct Problem {
  TestScene scene;
  Kkt kkt;
  MatrixXd Mt, J, gamma;
  VectorXd v, y;  ///< some point, v = 0 where masked
};

Problem some_problem(std::uint64_t seed, GeometricStiffness kind) {
  Random random(seed);
  Problem out{mixed_scene(seed, {.hard_angle = true}), {}, {}, {}, {}, {}, {}};
  const System& s = out.scene.system;
  const int n = 3 * s.nodes;
  out.kkt.prepare(s);
  out.kkt.set_step(kSigma, kRho);
  EXPECT_TRUE(out.kkt.evaluate(out.scene.state.q).ok());
  out.kkt.p = random.numbers(n, 5.0);
  out.kkt.r = random.numbers(s.rows);
  out.v = random.numbers(n);
  out.y = random.numbers(s.rows, 3.0);
  for (int i : s.masked) out.v[i] = out.kkt.p[i] = 0.0;

  const DenseRows rows = dense_rows(s, out.scene.state.q);
  VectorXd lambda = random.numbers(s.rows, 2.0);
  for (int k = 0; k < s.rows; ++k)
    if (s.stiffness[k] == 0.0) lambda[k] = 0.0;
  out.kkt.set_geometric_stiffness(kind, kSigma, out.scene.state, lambda);
  out.J = rows.jacobian;
  out.Mt = MatrixXd::Zero(n, n);
  for (int i = 0; i < n; ++i) out.Mt(i, i) = s.mass[i / 3] + kRho * s.forces.drag[i];
  if (kind == GeometricStiffness::kFull)
    out.Mt += kSigma * (dense_geometric(rows, lambda) + dense_user_stiffness(s, out.scene.state));
  VectorXd gamma(s.rows);
  for (int k = 0; k < s.rows; ++k)
    gamma[k] = s.stiffness[k] == 0.0 ? 1.0 : 1.0 / (s.stiffness[k] * (kSigma + kRho * s.damping_time[k]));
  out.gamma = gamma.asDiagonal();
  return out;
}

class Residual : public testing::TestWithParam<GeometricStiffness> {};

TEST_P(Residual, IsTheRightHandSideMinusTheMatrixTimesTheUnknowns) {
  for (const std::string& name : kernel_names()) {
    const KernelChoice choice(name);
    if (!choice.available()) continue;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const Problem x = some_problem(seed, GetParam());
      VectorXd residual_v, residual_y;
      (void)x.kkt.residual(x.v, x.y, &residual_v, &residual_y);
      VectorXd expected_v = x.kkt.p - (x.Mt * x.v - x.J.transpose() * x.y);
      const VectorXd expected_y = x.kkt.r - (-x.J * x.v - x.gamma * x.y);
      for (int i : x.scene.system.masked) expected_v[i] = 0.0;
      ASSERT_GT(expected_v.norm(), 1.0);
      ASSERT_GT(expected_y.norm(), 1.0);
      EXPECT_LT((residual_v - expected_v).norm(), 1e-13 * expected_v.norm());  // 4e-15
      EXPECT_LT((residual_y - expected_y).norm(), 1e-13 * expected_y.norm());  // 5e-16
    }
  }
}

TEST_P(Residual, FirstBlockIsRelativeToItsTerms) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Problem x = some_problem(seed, GetParam());
    const System& s = x.scene.system;
    x.kkt.r = -x.J * x.v - x.gamma * x.y;  // the second block is exact
    VectorXd error = x.kkt.p - x.Mt * x.v + x.J.transpose() * x.y, pull = x.J.transpose() * x.y;
    VectorXd inertial = VectorXd::Zero(x.v.size()), geometric = x.Mt * x.v;
    for (int i = 0; i < x.v.size(); ++i) {
      inertial[i] = (s.mass[i / 3] + kRho * s.forces.drag[i]) * x.v[i];
      geometric[i] -= inertial[i];
    }
    for (int i : s.masked) error[i] = pull[i] = geometric[i] = 0.0;
    pull -= geometric;  // the engine takes both as one term
    double rows = 0.0;  // |J||y| over the rows; a switched off distance row counts as the others
    for (int k = 0; k < s.rows; ++k)
      rows += (k < s.distance.size() ? 2.0 : x.J.row(k).squaredNorm()) * x.y[k] * x.y[k];
    const double terms = x.kkt.p.norm() + inertial.norm() + geometric.norm();
    const ResidualSize size = x.kkt.residual_size(x.v, x.y);
    ASSERT_GT(error.norm() / terms, 0.1);
    EXPECT_NEAR(size.backward_error, error.norm() / (terms + std::sqrt(rows)), 1e-12) << seed;  // 4e-16
    EXPECT_NEAR(size.balance_error, error.norm() / (terms + pull.norm()), 1e-12) << seed;       // 3e-16
  }
}

TEST_P(Residual, SecondBlockIsRelativeToItsTerms) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Problem x = some_problem(seed, GetParam());
    x.kkt.p = x.Mt * x.v - x.J.transpose() * x.y;  // the first block is exact
    for (int i : x.scene.system.masked) x.kkt.p[i] = 0.0;
    const VectorXd rate = x.J * x.v, error = x.kkt.r + rate + x.gamma * x.y;
    const double terms = x.kkt.r.norm() + (x.gamma * x.y).norm();
    const ResidualSize size = x.kkt.residual_size(x.v, x.y);
    ASSERT_GT(error.norm() / terms, 0.1);
    EXPECT_NEAR(size.backward_error, error.norm() / (terms + 2.0 * x.v.norm()), 1e-12) << seed;  // 1e-16
    EXPECT_NEAR(size.balance_error, error.norm() / (terms + rate.norm()), 1e-12) << seed;        // 2e-16
  }
}

TEST_P(Residual, IsAtRoundingForTheDenseSolution) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Problem x = some_problem(seed, GetParam());
    const System& s = x.scene.system;
    const int n = static_cast<int>(x.v.size()), m = s.rows;
    MatrixXd A(n + m, n + m);
    A << x.Mt, -x.J.transpose(), -x.J, -x.gamma;
    for (int i : s.masked) {
      A.row(i).setZero();
      A.col(i).setZero();
      A(i, i) = 1.0;
    }
    VectorXd b(n + m);
    b << x.kkt.p, x.kkt.r;
    const VectorXd solution = A.fullPivLu().solve(b);
    const VectorXd v = solution.head(n), y = solution.tail(m);
    ASSERT_GT(v.norm(), 0.1);
    ASSERT_GT(y.norm(), 0.1);
    const ResidualSize size = x.kkt.residual_size(v, y);
    EXPECT_LT(size.backward_error, 1e-14);  // 2e-15
    EXPECT_LT(size.balance_error, 1e-13);   // 2e-15
    EXPECT_LT(size.backward_error, x.kkt.residual_size(x.v, x.y).backward_error);
  }
}

TEST_P(Residual, SeesAnErrorOfEveryEntry) {
  const Problem x = some_problem(3, GetParam());
  const System& s = x.scene.system;
  VectorXd before_v, before_y, after_v, after_y;
  (void)x.kkt.residual(x.v, x.y, &before_v, &before_y);
  for (int i = 0; i < x.v.size(); ++i) {
    if (s.inverse_mass[i] == 0.0) continue;
    VectorXd v = x.v;
    v[i] += 1e-6;
    (void)x.kkt.residual(v, x.y, &after_v, &after_y);
    EXPECT_GT((after_v - before_v).norm(), 1e-8) << i;
  }
  for (int k = 0; k < x.y.size(); ++k) {
    VectorXd y = x.y;
    y[k] += 1e-6;
    (void)x.kkt.residual(x.v, y, &after_v, &after_y);
    EXPECT_GT((after_v - before_v).norm() + (after_y - before_y).norm(), 1e-8) << k;
  }
}

TEST_P(Residual, IsNanIfAnythingIsNotFinite) {
  const Problem x = some_problem(2, GetParam());
  for (double bad : {NAN, INFINITY}) {
    VectorXd v = x.v, y = x.y;
    v[20] = bad;
    EXPECT_TRUE(std::isnan(x.kkt.residual_size(v, x.y).backward_error));
    EXPECT_TRUE(std::isnan(x.kkt.residual_size(v, x.y).balance_error));
    for (int k : {x.scene.system.row_of_id[0], x.scene.system.rows - 1}) {
      y = x.y;
      y[k] = bad;
      EXPECT_TRUE(std::isnan(x.kkt.residual_size(x.v, y).backward_error));
      EXPECT_TRUE(std::isnan(x.kkt.residual_size(x.v, y).balance_error));
    }
    Kkt spoiled = x.kkt;
    spoiled.p[20] = bad;
    EXPECT_TRUE(std::isnan(spoiled.residual_size(x.v, x.y).backward_error));
    spoiled = x.kkt;
    spoiled.r[0] = bad;
    EXPECT_TRUE(std::isnan(spoiled.residual_size(x.v, x.y).backward_error));
  }
}

TEST_P(Residual, OfNothingIsZero) {
  Problem x = some_problem(1, GetParam());
  x.kkt.p.setZero();
  x.kkt.r.setZero();
  const ResidualSize size = x.kkt.residual_size(VectorXd::Zero(x.v.size()), VectorXd::Zero(x.y.size()));
  EXPECT_EQ(size.backward_error, 0.0);
  EXPECT_EQ(size.balance_error, 0.0);
}

INSTANTIATE_TEST_SUITE_P(Kinds, Residual,
                         testing::Values(GeometricStiffness::kOff, GeometricStiffness::kFull),
                         [](const auto& instance) {
                           return std::string(instance.param == GeometricStiffness::kOff ? "WithoutGeometric"
                                                                                         : "WithGeometric");
                         });

/// A load of 2 kg at rest on a rod to a world point: p is cancelled by the rod, v is what rounding leaves.
ResidualSize load_on_a_rod(double v_left, double y_error) {
  SystemBuilder builder;
  builder.add_world_point({0, 0, 0});
  builder.add_particle(2.0, {0, -1, 0});
  builder.add_distance({0}, {1}, {kRigid}, 1.0);
  builder.set_gravity({0, -9.81, 0});
  const auto [s, state] = builder.build();
  const double dt = 0.01;
  Kkt kkt;
  kkt.prepare(s);
  kkt.set_step(dt * dt, dt);
  EXPECT_TRUE(kkt.evaluate(state.q).ok());
  kkt.p = dt * s.forces.constant;
  kkt.r.setZero();
  VectorXd v = VectorXd::Zero(6), y = VectorXd::Zero(s.rows);
  v[4] = v_left;
  y[s.row_of_id[0]] = -dt * 2.0 * 9.81 * (1.0 + y_error);
  return kkt.residual_size(v, y);
}

TEST(ResidualAtRest, AcceptsAVelocityThatIsRounding) {
  EXPECT_LT(load_on_a_rod(1e-17, 0.0).backward_error, 1e-15);  // 0; against |v| alone it would be 0.5
}

TEST(ResidualAtRest, RefusesAVelocityThatIsNot) {
  EXPECT_GT(load_on_a_rod(1e-6, 0.0).backward_error, 1e-6);
}

TEST(ResidualAtRest, RefusesAWrongMultiplier) {
  EXPECT_GT(load_on_a_rod(0.0, 1e-6).backward_error, 1e-7);
}

TEST(KktSign, MinusGivesTheSchurComplementOfTheStepAndPlusAnIndefiniteOne) {
  // notes slip 1: with +gamma the Schur complement is M - dt^2 J^T D J
  SystemBuilder builder;
  for (int i = 0; i < 4; ++i) builder.add_particle(1.0, {1.0 * i, 0.2 * (i % 2), 0.0});
  for (int i = 0; i < 3; ++i) builder.add_distance({i}, {i + 1}, {100.0}, 0.9);
  const auto [s, state] = builder.build();
  Kkt kkt;
  kkt.prepare(s);
  kkt.set_step(0.04, 0.2);
  ASSERT_TRUE(kkt.evaluate(state.q).ok());
  const MatrixXd J = dense_rows(s, state.q).jacobian;
  const MatrixXd push = J.transpose() * kkt.inverse_gamma.asDiagonal() * J, M = kkt.mass.asDiagonal();
  const MatrixXd expected = M + 0.04 * J.transpose() * s.stiffness.asDiagonal() * J;
  ASSERT_GT(push.norm(), 1.0);
  EXPECT_LT((M + push - expected).norm(), 1e-14 * expected.norm());  // 2e-16
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<MatrixXd>(M + push).eigenvalues()[0], 0.99);
  EXPECT_LT(Eigen::SelfAdjointEigenSolver<MatrixXd>(M - push).eigenvalues()[0], -1.0);  // -12

  // the solution with the minus sign satisfies the residual of the engine, the one with plus does not
  const int n = 12, m = s.rows;
  kkt.p = s.inertia.cwiseProduct(VectorXd::LinSpaced(n, -1.0, 1.0));
  kkt.r = kkt.phi / 0.2;
  auto solved = [&](double sign) {
    MatrixXd A(n + m, n + m);
    A << M, -J.transpose(), -J, MatrixXd(sign * kkt.gamma.asDiagonal().toDenseMatrix());
    VectorXd b(n + m);
    b << kkt.p, kkt.r;
    return VectorXd(A.fullPivLu().solve(b));
  };
  const VectorXd minus = solved(-1.0), plus = solved(1.0);
  EXPECT_LT(kkt.residual_size(minus.head(n), minus.tail(m)).backward_error, 1e-15);  // 1e-16
  EXPECT_GT(kkt.residual_size(plus.head(n), plus.tail(m)).backward_error, 0.01);     // 0.5
}

}  // namespace
}  // namespace feder
