#pragma once

#include <array>
#include <memory>

#include "solvers/integrator.h"

namespace feder {

/// The classical Runge-Kutta method of order 4 on (q, v) (notes B3). Stable on the imaginary axis up to omega
/// dt = 2 sqrt 2. Hard rows: the index-1 system, J a = -Jdot v - phi_tt in every stage, and after the step a
/// projection of q and v onto the rows in the metric of M.
class Rk4 {
 public:
  static constexpr IntegratorInfo kInfo{"rk4", 4, false, false, "four right-hand sides per step; order 4"};
  static std::string refusal(const System&) { return {}; }

  Rk4(const System& system, const IntegratorOptions& options) : system_(&system), options_(options) {}
  Status prepare();
  Status step(double dt, State& state, History& history, EnergyLedger* ledger);
  const StepCounts& counts() const { return counts_; }
  /// lambda <- what each row pulls with at a state: -d phi - b phidot, and on hard rows what holds them there
  /// (one of many where they depend on each other). To be called after prepare().
  Status row_forces(const State& at, VectorXd& lambda);
  LinearSolver* row_solver() { return matrix_ ? &matrix_->solver : nullptr; }

 private:
  Status hold_rows(const State& at, VectorXd& force);
  Status project(State& at);

  struct Matrix {  // only with hard rows
    Kkt kkt;
    LinearSolver solver;
    VectorXd a, y, driven;
  };
  const System* system_;
  IntegratorOptions options_;
  std::unique_ptr<Matrix> matrix_;
  std::unique_ptr<Kkt> finite_;  // of row_forces
  State stage_;
  std::array<VectorXd, 4> force_, rate_;  // of v and of q
  StepCounts counts_;
};

}  // namespace feder
