#pragma once

#include <memory>

#include "solvers/integrator.h"

namespace feder {

/// Kick-drift-kick (notes B3): v+ = v + dt/2 M^-1 F(q, v),  q' = q + dt v+,  v' = v+ + dt/2 M^-1 F(q', v').
/// Bodies turn freely in the drift (rotate_freely), which changes their spin. The second kick is implicit in
/// v: a division with drag, one linear solve with row damping (the step matrix with sigma = 0, rho = dt/2),
/// nothing otherwise. Stable up to omega dt = 2 whatever the damping; symplectic without it.
class Leapfrog {
 public:
  static constexpr IntegratorInfo kInfo{"leapfrog", 2, false, true,
                                        "one right-hand side per step; symplectic without damping"};
  static std::string refusal(const System&) { return {}; }

  Leapfrog(const System& system, const IntegratorOptions& options);
  Status prepare();
  Status step(double dt, State& state, History& history, EnergyLedger* ledger);
  const StepCounts& counts() const { return counts_; }
  LinearSolver* row_solver() { return matrix_ ? &matrix_->solver : nullptr; }

 private:
  void drift(double dt, const VectorXd& q, State& next) const;
  Status solve_kick(double dt, const State& half, VectorXd& v_next);
  Status drift_on_rows(double dt, const VectorXd& q, VectorXd& w, State& next);

  struct Matrix {  // only where rows are damped or hard
    Kkt kkt;
    LinearSolver solver;
    VectorXd y, dv, phi;
  };
  const System* system_;
  IntegratorOptions options_;
  std::unique_ptr<Matrix> matrix_;
  VectorXd force_, v_next_;
  State next_;
  StepCounts counts_;
};

}  // namespace feder
