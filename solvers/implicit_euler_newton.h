#pragma once

#include "solvers/integrator.h"

namespace feder {

/// Implicit Euler solved to convergence: full Newton with line search on the incremental potential
///   Phi(v) = 1/2 |v - v_n|_M^2 + dt/2 v.B v + sum_k W_k(phi_k(q')) + P(q'),   q' = q_n + dt v,
///   W = 1/dt ((dt d + b) phi'^2 / 2 - b phi_n phi'),   P = potential of the external forces,
/// plus mu |phi| on hard rows (exact penalty). Kg is full; where that matrix is not positive definite, only
/// part of its negative part is kept (counted). Hard rows that depend on each other are all kept and the
/// iteration stabilised: in the matrix alone they get a gamma that falls with the residual (stabilised
/// sequential quadratic programming: Wright, Comput. Optim. Appl. 11, 1998), so that it converges although J
/// has no full rank, to rows that are all closed.
class ImplicitEulerNewton {
 public:
  static constexpr IntegratorInfo kInfo{
      "implicit_euler_newton", 1, true, false,
      "Newton to convergence with full geometric stiffness and line search"};
  static std::string refusal(const System&) { return {}; }

  ImplicitEulerNewton(const System& system, const IntegratorOptions& options)
      : system_(&system), options_(options), solver_(options.route, options.solve) {}
  Status prepare();
  Status step(double dt, State& state, History& history, EnergyLedger* ledger);
  const StepCounts& counts() const { return counts_; }
  LinearSolver& solver() { return solver_; }

 private:
  enum class Multipliers { kOfPhi, kOwn };  // y of the soft rows: from phi, so that g = 0, or an unknown
  struct Iterate {
    Multipliers multipliers = Multipliers::kOfPhi;
    State state;            // t_next, q', v'
    VectorXd phi, y;        // rows at q', y = dt lambda
    VectorXd residual, g;   // of the momentum balance and of the rows
    double relative = 0.0;  // |residual| against its terms, and |g| likewise
  };
  Status evaluate(double dt, const State& start, Multipliers multipliers, Iterate& at);
  Status solve_direction(double dt, const Iterate& at);
  Status factor_and_solve(const Iterate& at);
  Status ended(const Status& failure) const;
  bool frozen() const;
  double merit(double dt, const Iterate& at, double& magnitude) const;
  Status try_full_step(double dt, const State& start, double bound, Iterate& at, bool& taken);
  Status go_on_with_own(double dt, const State& start, Iterate& at, bool& taken);
  Status line_search(double dt, const State& start, Iterate& at);
  Status lengthen(double dt, const State& start, double before, double slope, Iterate& at);
  void keep_books(double dt, const State& start, const Iterate& end, EnergyLedger& ledger) const;

  const System* system_;
  IntegratorOptions options_;
  LinearSolver solver_;
  Kkt kkt_;
  Iterate at_, trial_;
  VectorXd v_start_;  // v_n after the implicit gyroscopic step of the bodies
  VectorXd external_, remembered_, dv_, dy_, lambda_, frozen_force_;
  double penalty_ = 0.0, kept_ = 1.0;  // kept_: fraction of the negative part of Kg
  bool own_allowed_ = true;            // far from the solution, too; see go_on_with_own
  int rises_ = 0;
  VectorXd v_before_own_, y_before_own_;
  bool rank_known_ = false, redundant_ = false;  // hard rows depend on each other
  StepCounts counts_;
};

}  // namespace feder
