// Rows of a step: the direct solve against dense algebra and the enumeration of active sets, its failures.
#include "solvers/step_row_solver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/solvers/random_step_rows.h"

namespace feder {
namespace {

using Eigen::MatrixXd;
using test::random_rows;
using Problem = test::StepRowProblem;

double relative(const VectorXd& a, const VectorXd& b) {
  return (a - b).norm() / b.norm();
}

TEST(StepRows, DirectSolveEqualsTheDenseMatrix) {
  double worst_y = 0.0, worst_v = 0.0;
  for (const int m : {1, 7, 48, 49, 150})
    for (const double gamma : {0.0, 0.5})
      for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        const Problem p = random_rows(seed, m, 5 * m + 20, 12, gamma);
        const VectorXd y_dense = p.schur().partialPivLu().solve(p.right());
        const VectorXd v_dense = p.v + p.inverse_mass.cwiseProduct(p.jacobian().transpose() * y_dense);
        ASSERT_GT((v_dense - p.v).norm(), 0.01);
        VectorXd v = p.v, y;
        StepRowSolver solver;
        const Status status = solver.solve(p.rows, p.inverse_mass, v, y);
        ASSERT_TRUE(status.ok()) << status.reason;
        EXPECT_EQ(solver.factorizations(), 1);
        worst_y = std::max(worst_y, relative(y, y_dense));
        worst_v = std::max(worst_v, relative(v, v_dense));
      }
  EXPECT_LT(worst_y, 1e-12);  // measured 1e-15
  EXPECT_LT(worst_v, 1e-13);  // measured 6e-16
}

TEST(StepRows, OneSolverServesPatternsThatStayAndThatChange) {
  StepRowSolver solver;
  // the same pattern with other values, another pattern of as many rows, a dense one, the first again
  Problem same = random_rows(1, 120, 500, 6, 0.0);
  Random random(9);
  for (double& value : same.rows.value) value = random.uniform();
  for (const Problem& p : {random_rows(1, 120, 500, 6, 0.0), same, random_rows(2, 120, 500, 6, 0.0),
                           random_rows(3, 20, 90, 6, 0.0), random_rows(1, 120, 500, 6, 0.0)}) {
    VectorXd v = p.v, y, v_fresh = p.v, y_fresh;
    StepRowSolver fresh;
    ASSERT_TRUE(solver.solve(p.rows, p.inverse_mass, v, y).ok());
    ASSERT_TRUE(fresh.solve(p.rows, p.inverse_mass, v_fresh, y_fresh).ok());
    EXPECT_EQ((y - y_fresh).norm(), 0.0);
    EXPECT_EQ((v - v_fresh).norm(), 0.0);
    ASSERT_GT(p.residual(p.v, VectorXd::Zero(y.size())).norm(), 1.0);
    EXPECT_LT(p.residual(v, y).norm(), 1e-12);  // measured 4e-15
  }
}

// ---- Unilateral rows

// The only y with y >= 0, w = S y - right >= 0, w y = 0, by trying all active sets.
VectorXd enumerate(const MatrixXd& S, const VectorXd& right) {
  const int m = static_cast<int>(right.size());
  VectorXd best;
  double least = std::numeric_limits<double>::infinity();
  for (int set = 0; set < 1 << m; ++set) {
    std::vector<int> on;
    for (int k = 0; k < m; ++k)
      if (set >> k & 1) on.push_back(k);
    VectorXd y = VectorXd::Zero(m);
    if (!on.empty()) {
      const VectorXd part = MatrixXd(S(on, on)).llt().solve(VectorXd(right(on)));
      y(on) = part;
    }
    VectorXd w = S * y - right;
    for (const int k : on) w[k] = 0.0;
    const double violation = -std::min(y.minCoeff(), w.minCoeff());
    if (violation < least) least = violation, best = y;
    if (least <= 0.0) break;
  }
  return best;
}

TEST(UnilateralRows, EqualTheEnumerationOfAllActiveSets) {
  double worst = 0.0;
  int pushing = 0, resting = 0;
  StepRowSolver solver;
  for (std::uint64_t seed = 1; seed <= 3000; ++seed) {
    // some with more rows than coordinates: definite by gamma alone
    const int m = 1 + static_cast<int>(seed % 10), n = seed % 3 ? 2 * m + 6 : 6;
    Problem p = random_rows(seed, m, n, 4, seed % 3 == 1 ? 0.0 : 0.3);
    p.rows.unilateral = true;
    const MatrixXd S = p.schur();
    if (Eigen::SelfAdjointEigenSolver<MatrixXd>(S).eigenvalues()[0] < 1e-4 * S.trace()) continue;
    const VectorXd expected = enumerate(S, p.right());
    // without a guess, and from any guess
    VectorXd v = p.v, y, v2 = p.v, y2 = Random(seed).numbers(m);
    ASSERT_TRUE(solver.solve(p.rows, p.inverse_mass, v, y).ok()) << seed;
    ASSERT_TRUE(solver.solve(p.rows, p.inverse_mass, v2, y2).ok()) << seed;
    pushing += static_cast<int>((expected.array() > 0.0).count());
    resting += static_cast<int>((expected.array() == 0.0).count());
    const double size = p.right().norm() / S.diagonal().minCoeff();
    worst = std::max({worst, (y - expected).norm() / size, (y2 - expected).norm() / size});
  }
  EXPECT_GT(pushing, 3000);
  EXPECT_GT(resting, 3000);
  EXPECT_LT(worst, 1e-12);  // measured 4e-14
}

TEST(UnilateralRows, MeetTheConditionsOfComplementarity) {
  for (const int m : {40, 60, 300, 2000})
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      Problem p = random_rows(seed, m, 2 * m, 6, 0.01);
      p.rows.unilateral = true;
      VectorXd v = p.v, y;
      StepRowSolver solver;
      const Status status = solver.solve(p.rows, p.inverse_mass, v, y);
      ASSERT_TRUE(status.ok()) << status.reason;
      const VectorXd w = p.residual(v, y);
      EXPECT_GE(y.minCoeff(), 0.0);
      EXPECT_GT(w.minCoeff(), -1e-12);                            // measured -9e-14
      EXPECT_LT(w.cwiseProduct(y).cwiseAbs().maxCoeff(), 1e-10);  // measured 6e-12
      EXPECT_GT((y.array() > 0.0).count(), m / 5);
      EXPECT_GT((w.array() > 1e-3).count(), m / 5);
      // the signs of the solution are a guess that holds
      VectorXd again = p.v;
      ASSERT_TRUE(solver.solve(p.rows, p.inverse_mass, again, y).ok());
      EXPECT_EQ(solver.factorizations(), 1);
    }
}

TEST(UnilateralRows, EndInSpiteOfRounding) {
  // half of the rows are three times another, r and J v cancel to 1e-12 of themselves: rounding decides which
  // one rests
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Problem p = random_rows(seed, 30, 120, 6, 0.0);
    p.v *= 1e9;
    p.rows.r = -(p.jacobian() * p.v) + 1e-3 * Random(seed).numbers(30);
    const StepRows once = p.rows;
    for (int k = 0; k < once.count(); ++k) {
      for (int i = once.first[k]; i < once.first[k + 1]; ++i) p.rows.add(once.column[i], 3.0 * once.value[i]);
      p.rows.close_row();
    }
    p.rows.r.resize(60);
    p.rows.r << once.r, 3.0 * once.r;
    p.rows.gamma = VectorXd::Constant(60, 1e-9);
    p.rows.unilateral = true;
    VectorXd v = p.v, y;
    const Status status = StepRowSolver().solve(p.rows, p.inverse_mass, v, y);
    ASSERT_TRUE(status.ok()) << seed << ": " << status.reason;
    ASSERT_GT(y.maxCoeff(), 0.0);
  }
}

TEST(UnilateralRows, SweepsEndAtTheDirectSolution) {
  Problem p = random_rows(4, 30, 80, 6, 0.1);
  p.rows.unilateral = true;
  VectorXd v = p.v, y, v_swept = p.v, y_swept = VectorXd::Zero(30);
  ASSERT_TRUE(StepRowSolver().solve(p.rows, p.inverse_mass, v, y).ok());
  for (int i = 0; i < 2000; ++i)
    if (sweep_step_rows(p.rows, p.inverse_mass, v_swept, y_swept) == 0.0) break;
  ASSERT_GT(y.maxCoeff(), 0.1);
  ASSERT_EQ(y.minCoeff(), 0.0);
  EXPECT_LT((y - y_swept).norm(), 1e-11);  // measured 1e-15
  EXPECT_LT((v - v_swept).norm(), 1e-12);  // measured 1e-15
}

// ---- Failures

TEST(StepRowFailures, DependentRowsAreSingularByNameAndLeaveTheVelocity) {
  for (const int m : {6, 48, 49, 200})
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      Problem p = random_rows(seed, m - 1, 6 * m + 20, 12, 0.0);
      // the last row is the sum of two others
      const MatrixXd J = p.jacobian();
      const VectorXd sum = J.row(1) + 3.0 * J.row(m / 2);
      for (int c = 0; c < sum.size(); ++c)
        if (sum[c] != 0.0) p.rows.add(c, sum[c]);
      p.rows.close_row();
      p.rows.r = Random(seed).numbers(m);
      p.rows.gamma = VectorXd::Zero(m);
      VectorXd v = p.v, y;
      const Status status = StepRowSolver().solve(p.rows, p.inverse_mass, v, y);
      EXPECT_EQ(status.code, StatusCode::kSingular) << m << ' ' << seed;
      EXPECT_NE(status.reason.find("depend"), std::string::npos);
      EXPECT_EQ((v - p.v).norm(), 0.0);
      EXPECT_EQ(y.norm(), 0.0);
      // compliance makes them independent
      p.rows.gamma.setConstant(1e-9);
      EXPECT_TRUE(StepRowSolver().solve(p.rows, p.inverse_mass, v, y).ok());
    }
}

TEST(StepRowFailures, ANaNIsNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const int m : {10, 100})
    for (int place = 0; place < 5; ++place) {
      Problem p = random_rows(1, m, 6 * m, 6, 0.1);
      const int column = p.rows.column[3];
      if (place == 0) p.rows.value[3] = nan;
      if (place == 1) p.rows.r[2] = nan;
      if (place == 2) p.rows.gamma[m / 2] = nan;
      if (place == 3) p.v[column] = nan;
      if (place == 4) p.inverse_mass[column] = nan;
      VectorXd v = p.v, y;
      EXPECT_EQ(StepRowSolver().solve(p.rows, p.inverse_mass, v, y).code, StatusCode::kNonFinite) << place;
    }
}

TEST(StepRowFailures, RowsThatMoveNothingAreLeftAlone) {
  for (const int m : {10, 100})
    for (const bool unilateral : {false, true}) {
      Problem p = random_rows(1, m, 8 * m, 6, 0.1);
      p.rows.gamma.setZero();
      p.rows.unilateral = unilateral;
      for (int i = p.rows.first[3]; i < p.rows.first[4]; ++i) p.inverse_mass[p.rows.column[i]] = 0.0;
      p.rows.r[3] = -5.0;  // far from met
      VectorXd v = p.v, y, v_swept = p.v, y_swept = VectorXd::Zero(m);
      const Status status = StepRowSolver().solve(p.rows, p.inverse_mass, v, y);
      ASSERT_TRUE(status.ok()) << status.reason;
      EXPECT_EQ(y[3], 0.0);
      EXPECT_GT(y.norm(), 0.1);
      for (int i = 0; i < 5000; ++i) sweep_step_rows(p.rows, p.inverse_mass, v_swept, y_swept);
      EXPECT_EQ(y_swept[3], 0.0);
      EXPECT_LT((v - v_swept).norm(), 1e-9);  // measured 5e-14
    }
}

// ---- Hard rows that depend on each other

// Rows that some v holds, three of them for every two coordinates; gamma is a part of each row's mobility.
Problem dependent_rows(std::uint64_t seed, int m, bool unilateral) {
  Problem p = random_rows(seed, m, 2 * m / 3, 6, 0.0);
  Random random(seed + 100);
  const VectorXd held = random.numbers(static_cast<int>(p.v.size()));
  p.rows.unilateral = unilateral;
  p.rows.r = -p.jacobian() * held;
  for (int i = 0; i < p.v.size(); ++i)
    if (p.inverse_mass[i] == 0.0) p.rows.r += p.jacobian().col(i) * (held[i] - p.v[i]);
  for (int k = 0; k < m; ++k) p.rows.gamma[k] = 1e-4 * p.rows.mobility(k, p.inverse_mass);
  for (int k = 0; k < m && unilateral; ++k) p.rows.r[k] += std::max(0.0, random.uniform());
  return p;
}

TEST(HardRows, CloseWhereTheyDependOnEachOther) {
  for (const bool unilateral : {false, true})
    for (const int m : {12, 45, 60, 400})
      for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        const Problem p = dependent_rows(seed, m, unilateral);
        const MatrixXd J = p.jacobian();
        VectorXd v = p.v, y, soft = p.v, y_soft;
        StepRowSolver solver;
        ASSERT_TRUE(solver.solve(p.rows, p.inverse_mass, soft, y_soft).ok());
        const Status status = solver.close(p.rows, p.inverse_mass, 1e-9, v, y);
        ASSERT_TRUE(status.ok()) << status.reason;
        EXPECT_GT(solver.rounds(), 1);
        auto left = [&](const VectorXd& at) {
          const VectorXd w = J * at + p.rows.r;
          return unilateral ? -w.minCoeff() : w.lpNorm<Eigen::Infinity>();
        };
        EXPECT_GT(left(soft), 1e-6) << m;
        EXPECT_LT(left(v), 1.01e-9) << m;
        // the v next to the start: pushes alone, by rows that are closed
        EXPECT_LT((v - p.v - p.inverse_mass.cwiseProduct(J.transpose() * y)).norm(),
                  1e-12 * (v - p.v).norm());
        if (!unilateral) continue;
        EXPECT_GE(y.minCoeff(), 0.0);
        const VectorXd w = J * v + p.rows.r;
        for (int k = 0; k < m; ++k)
          if (y[k] > 0.0) EXPECT_LT(w[k], 1.01e-9) << m;
      }
}

TEST(HardRows, OfWhichNoneHoldsAllAreRefused) {
  Problem p;
  for (const double side : {1.0, -1.0, 1.0}) {
    p.rows.add(0, side);
    p.rows.close_row();
  }
  p.rows.r = Eigen::Vector3d(-1.0, -1.0, 0.5);  // v >= 1, v <= -1
  p.rows.gamma = VectorXd::Constant(3, 1e-4);
  p.rows.unilateral = true;
  VectorXd v = VectorXd::Constant(1, 0.25), y;
  const VectorXd one = VectorXd::Ones(1);
  const Status status = StepRowSolver().close(p.rows, one, 1e-9, v, y);
  EXPECT_EQ(status.code, StatusCode::kNotConverged);
  EXPECT_NE(status.reason.find("contradict"), std::string::npos) << status.reason;
  EXPECT_EQ(v[0], 0.25);
  EXPECT_EQ(y.norm(), 0.0);
  p.rows.r[1] = 2.0;  // v <= 2
  ASSERT_TRUE(StepRowSolver().close(p.rows, one, 1e-9, v, y).ok());
  EXPECT_NEAR(v[0], 1.0, 1.01e-9);
}

TEST(HardRows, KeepTheirFactorWhileTheSameRowsPush) {
  const Problem p = dependent_rows(1, 300, false);
  VectorXd v = p.v, y;
  StepRowSolver solver;
  const Status status = solver.close(p.rows, p.inverse_mass, 1e-9, v, y);
  ASSERT_TRUE(status.ok()) << status.reason;
  EXPECT_GT(solver.rounds(), 2);
  EXPECT_EQ(solver.factorizations(), 1);
}

}  // namespace
}  // namespace feder
