// Hard rows that depend on each other: solved where they agree, refused by name where they do not.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "solvers/simulate.h"
#include "tests/solvers/redundant_mechanism.h"
#include "tests/support/campaign.h"

namespace feder {
namespace {

using Eigen::MatrixXd;
using test::campaign_cases;
using test::Redundancy;
using test::redundant_mechanism;

/// The rows of a linearisation as matrices, scaled: J W^1/2 with every row of length 1.
struct Dense {
  MatrixXd scaled;         // D^-1/2 J W^1/2
  VectorXd root_mobility;  // D^1/2
  VectorXd root_inverse_mass;

  explicit Dense(const Kkt& kkt) : root_mobility(row_mobility(kkt).cwiseSqrt()) {
    const int n = static_cast<int>(kkt.mass.size());
    root_inverse_mass = kkt.inverse_mass.cwiseSqrt();
    scaled.resize(kkt.system->rows, n);
    VectorXd column;
    for (int i = 0; i < n; ++i) {
      kkt.multiply_jacobian(VectorXd::Unit(n, i), column);
      scaled.col(i) = column.cwiseQuotient(root_mobility) * root_inverse_mass[i];
    }
  }
  Eigen::JacobiSVD<MatrixXd> svd() const {
    Eigen::JacobiSVD<MatrixXd> out(scaled, Eigen::ComputeThinU | Eigen::ComputeThinV);
    out.setThreshold(1e-9);
    return out;
  }
};

struct Solved {
  VectorXd v, y;
};

/// Least |M^1/2 (v - W p)| among those with least |J v + r|, and the multipliers of least D-norm.
Solved minimum_norm(const Dense& dense, const VectorXd& p, const VectorXd& r) {
  const auto svd = dense.svd();
  const VectorXd free = dense.root_inverse_mass.cwiseProduct(p);  // M^1/2 W p
  const VectorXd wanted = -r.cwiseQuotient(dense.root_mobility) - dense.scaled * free;
  const VectorXd push = svd.solve(wanted);
  const Eigen::JacobiSVD<MatrixXd> transposed = [&] {
    Eigen::JacobiSVD<MatrixXd> out(dense.scaled.transpose(), Eigen::ComputeThinU | Eigen::ComputeThinV);
    out.setThreshold(1e-9);
    return out;
  }();
  return {dense.root_inverse_mass.cwiseProduct(free + push),
          VectorXd(transposed.solve(push)).cwiseQuotient(dense.root_mobility)};
}

Kkt hard_rows_alone(const System& s, const State& state) {
  Kkt kkt;
  kkt.prepare(s);
  kkt.set_step(0.0, 0.0);
  EXPECT_TRUE(kkt.evaluate(state.q).ok());
  return kkt;
}

SolveReport solve(const char* route, Kkt kkt, Solved& out, RowRank* rank = nullptr) {
  LinearSolver solver(route);
  SolveReport report;
  report.status = solver.analyze(*kkt.system, false);
  if (report.status.ok()) report.status = solver.factor(kkt);
  if (report.status.ok()) report = solver.solve(kkt, out.v, out.y);
  if (rank) *rank = solver.rank();
  return report;
}

Redundancy kind_of(int seed) {
  return static_cast<Redundancy>(seed % test::kRedundancies);
}

TEST(Campaign, RedundantMechanismsAreSolvedAsTheMinimumNormSolution) {
  double worst_v = 0.0, worst_y = 0.0;
  for (int seed = 0; seed < campaign_cases(5000); ++seed) {
    const auto [s, state] = redundant_mechanism(seed, kind_of(seed));
    Kkt kkt = hard_rows_alone(s, state);
    Random random(seed + 99);
    for (int i = 0; i < kkt.p.size(); ++i) kkt.p[i] = s.inertia[i] * random.uniform(-5.0, 5.0);
    for (int i : s.masked) kkt.p[i] = 0.0;
    VectorXd any = random.numbers(static_cast<int>(kkt.p.size()));
    for (int i : s.masked) any[i] = 0.0;
    kkt.multiply_jacobian(any, kkt.r);  // a rate that all rows can give
    const Dense dense(kkt);
    const int rank = static_cast<int>(dense.svd().rank());
    ASSERT_LT(rank, s.rows) << "seed " << seed;
    const Solved expected = minimum_norm(dense, kkt.p, kkt.r);
    for (const char* route : {"dual", "kkt"}) {
      Solved found;
      RowRank seen;
      const SolveReport report = solve(route, kkt, found, &seen);
      ASSERT_TRUE(report.status.ok()) << "seed " << seed << " " << route << ": " << report.status.reason;
      EXPECT_EQ(report.redundant_rows, s.rows - rank) << seed;
      EXPECT_EQ(seen.rank, rank) << seed << " " << route;
      worst_v = std::max(worst_v, (found.v - expected.v).norm() / expected.v.norm());
      const VectorXd least = least_norm_multipliers(s, state.q, found.y);
      worst_y = std::max(worst_y, (least - expected.y).norm() / expected.y.norm());
    }
  }
  EXPECT_LT(worst_v, 1e-8);
  EXPECT_LT(worst_y, 1e-4);
  std::printf("redundant mechanisms: v %.2g, y %.2g\n", worst_v, worst_y);
}

TEST(Campaign, ContradictingMechanismsAreRefusedNamingAMember) {
  for (int seed = 0; seed < campaign_cases(5000); ++seed) {
    const auto [s, state] = redundant_mechanism(seed, kind_of(seed), 0.05);
    Kkt kkt = hard_rows_alone(s, state);
    const auto svd = Eigen::JacobiSVD<MatrixXd>(Dense(kkt).scaled, Eigen::ComputeFullU);
    for (const char* name : {"implicit_euler_notes", "leapfrog", "implicit_euler_newton"}) {
      Integrator integrator = make_integrator(name, s);
      State moving = state;
      History history;
      const RunResult run = simulate(s, integrator, moving, history, {.dt = 0.01, .end_time = 0.1});
      ASSERT_EQ(run.status.code, StatusCode::kInconsistent)
          << "seed " << seed << " " << name << ": " << run.status.reason;
      // the named row has a part in a null vector of J^T
      int named = -1;
      for (int k = 0; k < s.rows; ++k)
        if (run.status.reason.rfind(s.row_name(k), 0) == 0) named = k;
      ASSERT_GE(named, 0) << run.status.reason;
      double part = 0.0;
      for (Eigen::Index j = 0; j < svd.matrixU().cols(); ++j)
        if (j >= svd.singularValues().size() || svd.singularValues()[j] < 1e-5)  // one of 5000 is that close
          for (int k = 0; k < s.rows; ++k)
            if (s.row_name(k) == s.row_name(named)) part = std::max(part, std::abs(svd.matrixU()(k, j)));
      EXPECT_GT(part, 1e-6) << "seed " << seed << ": " << run.status.reason;
    }
  }
}

TEST(Redundant, MechanismsRunUnderEveryIntegratorThatTakesHardRows) {
  for (int kind = 0; kind < test::kRedundancies; ++kind) {
    const auto [s, start] = redundant_mechanism(7 + kind, static_cast<Redundancy>(kind));
    for (const char* name : {"implicit_euler_notes", "implicit_euler_newton", "leapfrog", "rk4"}) {
      Integrator integrator = make_integrator(name, s);
      State state = start;
      History history;
      const RunResult run = simulate(s, integrator, state, history, {.dt = 2e-3, .end_time = 0.5});
      ASSERT_TRUE(run.status.ok()) << kind << " " << name << ": " << run.status.reason;
      VectorXd phi;
      evaluate_phi(s, state.q, phi);
      if (std::string(name) != "implicit_euler_notes")
        EXPECT_LT(phi.cwiseAbs().maxCoeff(), 1e-10) << kind << " " << name;
      if (kind != static_cast<int>(Redundancy::kPlates)) EXPECT_GT((state.q - start.q).norm(), 1e-3) << kind;
    }
  }
}

}  // namespace
}  // namespace feder
