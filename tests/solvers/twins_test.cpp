// The corrected formulas of notes.md section 0 that concern springs pass, the formulas as printed fail (slips
// 1 to 4).
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include "models/catalog.h"
#include "solvers/simulate.h"
#include "tests/solvers/random_system.h"

namespace feder {
namespace {

constexpr double kDt = 1.0 / 60.0;

// M, J, D^-1 of a chain of 6 links, written out densely.
struct DenseChain {
  Eigen::MatrixXd M, J, C;
  VectorXd v, phi;
  DenseChain() {
    const auto [system, state] =
        test::random_system(4, {.particles = 6, .stiffness = 1e4, .bending = false, .loops = false});
    Kkt kkt = test::implicit_euler_kkt(system, state, kDt);
    std::vector<int> free;
    for (int i = 0; i < state.v.size(); ++i)
      if (system.inverse_mass[i] > 0.0) free.push_back(i);
    std::vector<int> rows;
    for (int k = 0; k < system.rows; ++k)
      if (system.stiffness[k] > 0.0) rows.push_back(k);
    const Eigen::Index n = static_cast<Eigen::Index>(free.size()), m = static_cast<Eigen::Index>(rows.size());
    M = C = Eigen::MatrixXd::Zero(0, 0);
    M.setZero(n, n), J.setZero(m, n), C.setZero(m, m), v.setZero(n), phi.setZero(m);
    VectorXd unit = VectorXd::Zero(state.v.size()), column;
    for (Eigen::Index j = 0; j < n; ++j) {
      M(j, j) = system.inertia[free[j]];
      v[j] = state.v[free[j]];
      unit[free[j]] = 1.0;
      kkt.multiply_jacobian(unit, column);
      for (Eigen::Index k = 0; k < m; ++k) J(k, j) = column[rows[k]];
      unit[free[j]] = 0.0;
    }
    for (Eigen::Index k = 0; k < m; ++k) {
      C(k, k) = 1.0 / system.stiffness[rows[k]];
      phi[k] = 0.05 + 0.01 * static_cast<double>(k);
    }
  }
  Eigen::MatrixXd step_matrix(double sign) const {
    Eigen::MatrixXd K(M.rows() + J.rows(), M.rows() + J.rows());
    K << M, -J.transpose(), -J, sign * C / (kDt * kDt);
    return K;
  }
  Eigen::MatrixXd primal() const { return M + kDt * kDt * J.transpose() * C.inverse() * J; }
  VectorXd primal_velocity() const {
    return primal().ldlt().solve(M * v - kDt * J.transpose() * C.inverse() * phi);
  }
  VectorXd solve(const Eigen::MatrixXd& K, const VectorXd& second) const {
    VectorXd b(K.rows());
    b << M * v, second;
    return K.fullPivLu().solve(b).head(M.rows());
  }
};

TEST(Slip1, MinusSignGivesTheVelocityOfThePrimalSystem) {
  const DenseChain chain;
  const VectorXd v = chain.solve(chain.step_matrix(-1.0), chain.phi / kDt),
                 expected = chain.primal_velocity();
  ASSERT_GT(expected.norm(), 0.1);
  EXPECT_LT((v - expected).norm() / expected.norm(), 1e-12);  // measured 1e-15
}

TEST(Slip1, PlusSignAsPrintedMissesIt) {
  const DenseChain chain;
  const VectorXd v = chain.solve(chain.step_matrix(+1.0), chain.phi / kDt),
                 expected = chain.primal_velocity();
  EXPECT_GT((v - expected).norm() / expected.norm(), 0.1);
}

TEST(Slip1, OnlyTheMinusSignHasAPositiveSchurComplement) {
  const DenseChain chain;
  auto smallest = [&](double sign) {
    const Eigen::MatrixXd S = chain.M - sign * kDt * kDt * chain.J.transpose() * chain.C.inverse() * chain.J;
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(S).eigenvalues().minCoeff();
  };
  EXPECT_GT(smallest(-1.0), 0.0);
  EXPECT_LT(smallest(+1.0), -0.1);
}

TEST(Slip2, RightHandSidePhiCorrectsThePositionOfRods) {
  // rods that start 1 mm too long: one linear step with rhs phi/dt ends on the linearised constraint
  Model model = make_model("S1h(10)");
  for (int i = 3; i < model.state.q.size(); i += 3) model.state.q[i] *= 1.1;
  Kkt kkt = test::implicit_euler_kkt(model.system, model.state, kDt);
  VectorXd v, y, Jv;
  LinearSolver solver("kkt");
  ASSERT_TRUE(solver.analyze(model.system, false).ok());
  ASSERT_TRUE(solver.factor(kkt).ok());
  ASSERT_TRUE(solver.solve(kkt, v, y).status.ok());
  kkt.multiply_jacobian(v, Jv);
  ASSERT_GT(kkt.phi.norm(), 1e-3);
  EXPECT_LT((kkt.phi + kDt * Jv).norm(), 1e-12);  // measured 1e-17

  // as printed: second row -D^-1 lambda_t, which is 0 for rods
  kkt.r.setZero();
  ASSERT_TRUE(solver.solve(kkt, v, y).status.ok());
  kkt.multiply_jacobian(v, Jv);
  EXPECT_GT((kkt.phi + kDt * Jv).norm(), 0.9 * kkt.phi.norm());
}

TEST(Slip3, SchurComplementOfTheSymmetricMatrixIsMPlusStiffness) {
  const DenseChain chain;
  const Eigen::MatrixXd gamma = chain.C / (kDt * kDt);
  const Eigen::MatrixXd schur = chain.M + chain.J.transpose() * gamma.inverse() * chain.J;
  EXPECT_LT((schur - chain.primal()).norm() / schur.norm(), 1e-14);
  // as printed: E + dt^2 M^-1 J^T D J, which is not symmetric, so Cholesky does not apply
  const Eigen::MatrixXd printed = chain.M.inverse() * chain.primal();
  EXPECT_GT((printed - printed.transpose()).norm() / printed.norm(), 1e-3);
}

TEST(Slip4, NotesStepIsNotUnconditionallyStable) {
  // the same string, step and start: the notes' step explodes where the one with geometric stiffness does not
  auto growth = [](const char* name) {
    Model model = make_model("taut_string:modes=-1:1e-9");
    Integrator integrator = make_integrator(name, model.system);
    const double before =
        Eigen::Map<VectorXd, 0, Eigen::InnerStride<3>>(model.state.q.data() + 1, model.system.nodes).norm();
    History history;
    (void)simulate(model.system, integrator, model.state, history,
                   {.dt = 0.05, .end_time = 5.0, .divergence = 1e30});
    return Eigen::Map<VectorXd, 0, Eigen::InnerStride<3>>(model.state.q.data() + 1, model.system.nodes)
               .norm() /
           before;
  };
  EXPECT_LT(growth("implicit_euler_geometric"), 1.0);
  EXPECT_GT(growth("implicit_euler_notes"), 1e4);
}

// Implicit Euler for the linear chain in closed form, mode by mode: (z_j', w_j') = (z_j + dt w_j') with
// w_j' = (w_j - dt omega_j^2 z_j) / (1 + dt^2 omega_j^2), written as dense linear algebra on M and K.
State exact_implicit_euler(const System& system, const State& start, double dt, int steps) {
  Kkt kkt = test::implicit_euler_kkt(system, start, dt);
  const Eigen::Index n = start.q.size();
  Eigen::MatrixXd J(system.rows, n);
  VectorXd unit = VectorXd::Zero(n), column;
  for (Eigen::Index j = 0; j < n; ++j) {
    unit[j] = 1.0;
    kkt.multiply_jacobian(unit, column);
    J.col(j) = system.inverse_mass[j] > 0.0 ? column : VectorXd::Zero(system.rows);
    unit[j] = 0.0;
  }
  const Eigen::MatrixXd K = J.transpose() * system.stiffness.asDiagonal() * J;
  Eigen::MatrixXd A = dt * dt * K;
  for (Eigen::Index i = 0; i < n; ++i) A(i, i) += system.inverse_mass[i] > 0.0 ? system.inertia[i] : 1.0;
  const Eigen::LDLT<Eigen::MatrixXd> factor(A);
  const VectorXd force_start = J.transpose() * (system.stiffness.asDiagonal() * kkt.phi);
  State at = start;
  for (int k = 0; k < steps; ++k) {
    VectorXd b = system.inertia.cwiseProduct(at.v) - dt * (force_start + K * (at.q - start.q));
    for (Eigen::Index i = 0; i < n; ++i)
      if (system.inverse_mass[i] == 0.0) b[i] = 0.0;
    at.v = factor.solve(b);
    at.q += dt * at.v;
  }
  return at;
}

TEST(LinearChain, NotesStepEqualsExactImplicitEulerByAllRoutes) {
  const Model model = make_model("chain:n=50");
  const double dt = model.end_time / 200.0;
  const State expected = exact_implicit_euler(model.system, model.state, dt, 100);
  double largest_v = 0.0;
  for (int k = 1; k <= 10; ++k)
    largest_v = std::max(largest_v, model.exact(k * model.end_time / 10.0 / 1.7).v.norm());
  ASSERT_GT((expected.q - model.state.q).norm(), 1e-5);
  for (const char* route : {"kkt", "primal", "dual"}) {
    State state = model.state;
    History history;
    ImplicitEulerNotes integrator(model.system, {.route = route});
    ASSERT_TRUE(integrator.prepare().ok());
    for (int k = 0; k < 100; ++k) ASSERT_TRUE(integrator.step(dt, state, history, nullptr).ok());
    const double q_error = (state.q - expected.q).norm() / expected.q.norm(),
                 v_error = (state.v - expected.v).norm() / largest_v;
    EXPECT_LT(q_error, 1e-12) << route;  // measured 1e-15
    EXPECT_LT(v_error, 1e-12) << route;  // measured 5e-14, against the largest speed of the run
  }
}

}  // namespace
}  // namespace feder
