// The pseudo-inverse as the dual route with M = E (notes F4, slip 9), and where it fails: singular poses
// (F6).
#include "solvers/pseudo_inverse.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/kkt.h"
#include "models/robot/arms.h"
#include "solvers/step_row_solver.h"
#include "tests/support/random.h"

namespace feder {
namespace {

using Eigen::MatrixXd;
constexpr double kPi = std::numbers::pi;

MatrixXd random_matrix(Random& random, int rows, int columns) {
  MatrixXd J(rows, columns);
  for (int j = 0; j < columns; ++j) J.col(j) = random.numbers(rows);
  return J;
}

// ---- F4: the pseudo-inverse

TEST(PseudoInverse, IsARightInverseForMoreJointsThanRows) {
  Random random(1);
  int inverted = 0;
  for (int i = 0; i < 50; ++i) {
    const int m = 1 + random.below(6), n = m + random.below(3);
    const MatrixXd J = random_matrix(random, m, n);
    if (smallest_singular_value(J) < 0.05) continue;
    ++inverted;
    EXPECT_LT((J * pseudo_inverse(J) - MatrixXd::Identity(m, m)).norm(), 1e-12);  // 6e-14
  }
  EXPECT_GT(inverted, 25);
}

TEST(PseudoInverse, GivesTheShortestStep) {
  Random random(2);
  const MatrixXd J = random_matrix(random, 3, 6);
  const VectorXd e = random.numbers(3), x = minimum_norm_step(J, e);
  EXPECT_LT((J * x - e).norm(), 1e-14);
  // any other solution is longer by what it has in the null space
  const MatrixXd null = MatrixXd::Identity(6, 6) - pseudo_inverse(J) * J;
  for (int i = 0; i < 20; ++i) {
    const VectorXd extra = null * random.numbers(6);
    ASSERT_GT(extra.norm(), 1e-3);
    EXPECT_LT((J * extra).norm(), 1e-13);
    EXPECT_NEAR((x + extra).squaredNorm(), x.squaredNorm() + extra.squaredNorm(), 1e-13);
  }
}

// Slip 9: the notes print J^T (J J^T)^-1 for m >= n, where J J^T has no inverse.
TEST(PseudoInverse, TurnsToTheOtherSideForMoreRowsThanJoints) {
  Random random(3);
  for (int i = 0; i < 20; ++i) {
    const int n = 1 + random.below(5), m = n + 1 + random.below(3);
    const MatrixXd J = random_matrix(random, m, n);
    EXPECT_LT((pseudo_inverse(J) * J - MatrixXd::Identity(n, n)).norm(), 1e-10);
    const Eigen::JacobiSVD<MatrixXd> printed(J * J.transpose());
    EXPECT_LT(printed.singularValues().minCoeff(), 1e-15 * printed.singularValues()[0]);
    // least squares: nothing of the residual is left along J
    const VectorXd e = random.numbers(m), x = minimum_norm_step(J, e);
    ASSERT_GT((J * x - e).norm(), 1e-3);
    EXPECT_LT((J.transpose() * (J * x - e)).norm(), 1e-12);
  }
}

TEST(PseudoInverse, BothSidesAgreeUnderDamping) {
  Random random(4);
  const MatrixXd J = random_matrix(random, 6, 4);
  const VectorXd e = random.numbers(6);
  const MatrixXd S = J * J.transpose() + 0.01 * MatrixXd::Identity(6, 6);
  EXPECT_LT((minimum_norm_step(J, e, 0.01) - J.transpose() * S.inverse() * e).norm(), 1e-13);
}

TEST(PseudoInverse, StaysBoundedNearASingularPoseIfDamped) {
  const KinematicMap map = kinematic_map(planar_2r(1.0, 1.0));
  const Damping damping{.threshold = 0.1, .most = 1e-2};
  double undamped = 0.0, damped = 0.0;
  for (const double B : {1e-1, 1e-3, 1e-6, 0.0}) {
    Pose tool;
    ToolJacobian J;
    map.evaluate(VectorXd{{0.3, B}}.data(), tool, J);
    const MatrixXd A = J.topRows<2>();
    const VectorXd e = -tool.position.head<2>() / tool.position.norm();  // straight to the base
    const double gamma = damping.gamma(smallest_singular_value(A));
    damped = std::max(damped, minimum_norm_step(A, e, gamma).norm());
    if (B > 0.0) undamped = std::max(undamped, minimum_norm_step(A, e).norm());
  }
  EXPECT_GT(undamped, 1e5);  // 2e6
  EXPECT_LT(damped, 5.0);    // 4.5
}

// The three forms of S = J J^T + gamma: here, over step rows, and the dual route of the step matrix.
TEST(PseudoInverse, IsTheDualSchurComplementOfStepRows) {
  Random random(5);
  for (int i = 0; i < 20; ++i) {
    const int m = 1 + random.below(6), n = 3 * (1 + random.below(4));
    const MatrixXd J = random_matrix(random, m, n);
    const VectorXd e = random.numbers(m);
    StepRows rows;
    for (int k = 0; k < m; ++k) {
      for (int j = 0; j < n; ++j) rows.add(j, J(k, j));
      rows.close_row();
    }
    rows.gamma = VectorXd::Constant(m, 0.05);
    rows.r = -e;
    VectorXd v = VectorXd::Zero(n), y;
    StepRowSolver solver;
    ASSERT_TRUE(solver.solve(rows, VectorXd::Ones(n), v, y).ok());
    const VectorXd x = minimum_norm_step(J, e, 0.05);
    ASSERT_GT(x.norm(), 1e-3);
    EXPECT_LT((v - x).norm(), 1e-13 * x.norm());

    SmallDual S;
    S.reset(m, 0.05);
    for (int j = 0; j < n; ++j) S.add(J.col(j).data());
    VectorXd small = e;
    ASSERT_TRUE(S.factor());
    S.solve(small.data());
    EXPECT_LT((small - y).norm(), 1e-13 * y.norm());
  }
}

TEST(PseudoInverse, IsTheDualRouteOfAnEquivalentSystem) {
  // four particles of mass 1 on equal springs: J of the rows, gamma = 1 / (dt^2 d)
  Random random(6);
  SystemBuilder builder;
  std::vector<Anchor> nodes;
  for (int i = 0; i < 4; ++i) nodes.push_back(builder.add_particle(1.0, random.vector()));
  const double stiffness = 50.0, dt = 0.1;
  for (int i = 0; i < 3; ++i) builder.add_distance(nodes[i], nodes[i + 1], {stiffness}, 0.4);
  builder.add_distance(nodes[0], nodes[3], {stiffness}, 0.7);
  const auto [system, state] = builder.build();
  Kkt kkt;
  kkt.prepare(system);
  kkt.set_step(dt * dt, dt);
  ASSERT_TRUE(kkt.evaluate(state.q).ok());
  MatrixXd J(system.rows, 12);
  VectorXd column;
  for (int j = 0; j < 12; ++j) {
    kkt.multiply_jacobian(VectorXd::Unit(12, j), column);
    J.col(j) = column;
  }
  VectorXd e = random.numbers(system.rows);
  for (int k = 0; k < system.rows; ++k)
    if (!system.active(k)) e[k] = 0.0;
  kkt.p = VectorXd::Zero(12);
  kkt.r = -e;
  LinearSolver solver("dual", {});
  ASSERT_TRUE(solver.analyze(system, false).ok());
  ASSERT_TRUE(solver.factor(kkt).ok());
  VectorXd v, y;
  ASSERT_TRUE(solver.solve(kkt, v, y).status.ok());
  const VectorXd x = minimum_norm_step(J, e, 1.0 / (dt * dt * stiffness));
  ASSERT_GT(x.norm(), 0.1);
  EXPECT_LT((v - x).norm(), 1e-13 * x.norm());
}

// ---- F6: singular poses

TEST(Singularity, OfTwoLinksIsWhereTheyAreInLine) {
  const double a = 0.8, b = 0.5;
  const KinematicMap map = kinematic_map(planar_2r(a, b));
  Pose tool;
  ToolJacobian J;
  Random random(9);
  for (int i = 0; i < 100; ++i) {
    const VectorXd q{{random.uniform(-kPi, kPi), random.uniform(-kPi, kPi)}};
    map.evaluate(q.data(), tool, J);
    EXPECT_NEAR(J.topRows<2>().determinant(), a * b * std::sin(q[1]), 1e-15);
    EXPECT_NEAR(manipulability(J.topRows<2>()), a * b * std::abs(std::sin(q[1])), 1e-15);
  }
  // zeros by bisection of the determinant over a turn of B: exactly 0 and pi
  auto determinant = [&](double B) {
    map.evaluate(VectorXd{{0.7, B}}.data(), tool, J);
    return J.topRows<2>().determinant();
  };
  std::vector<double> zeros;
  for (double low = -1.0; low < -1.0 + 2.0 * kPi; low += 0.1) {
    if (determinant(low) * determinant(low + 0.1) > 0.0) continue;
    double l = low, h = low + 0.1;
    for (int i = 0; i < 60; ++i) (determinant(l) * determinant(0.5 * (l + h)) > 0.0 ? l : h) = 0.5 * (l + h);
    zeros.push_back(l);
  }
  ASSERT_EQ(zeros.size(), 2u);
  EXPECT_NEAR(zeros[0], 0.0, 1e-15);
  EXPECT_NEAR(zeros[1], kPi, 1e-15);
}

TEST(Singularity, OfTheWristIsWhereItsAxesAreInLine) {
  const KinematicMap map = kinematic_map(puma560());
  Pose tool;
  ToolJacobian J;
  for (const double q5 : {0.3, 1e-3, 0.0}) {
    map.evaluate(VectorXd{{0.3, 0.5, -0.4, 0.6, q5, -0.2}}.data(), tool, J);
    const double smallest = smallest_singular_value(J);
    if (q5 == 0.0)
      EXPECT_LT(smallest, 1e-15);
    else
      EXPECT_GT(smallest, 0.01 * q5);
  }
}

TEST(Damping, GrowsTowardsSingularPoses) {
  const Damping damping{.threshold = 0.2, .most = 1e-2};
  EXPECT_EQ(damping.gamma(0.2), 0.0);
  EXPECT_EQ(damping.gamma(0.0), 1e-2);
  EXPECT_NEAR(damping.gamma(0.1), 0.75e-2, 1e-16);
}

}  // namespace
}  // namespace feder
