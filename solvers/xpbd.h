#pragma once

#include "engine/step_rows.h"
#include "solvers/integrator.h"
#include "solvers/row_sweep.h"

namespace feder {

/// Position based dynamics with compliance (XPBD: Macklin, Mueller, Chentanez 2016; hard rows: Kaczmarz,
/// notes H3 to H5): implicit Euler whose rows are not solved for but swept over. A step is cut into
/// `substeps` equal parts; in each, forces without rows act first, then `sweeps` sweeps project onto the
/// rows, J where the nodes are by then (or, `frozen_rows`, as at the substep's start: then enough sweeps give
/// the linearised implicit step). Sweeps end early where they no longer change anything. A step shorter
/// than the one before closes hard rows as slowly as that one did. How stiff a row
/// really is depends on sweeps and step (notes H6).
class Xpbd {
 public:
  static constexpr IntegratorInfo kInfo{
      "xpbd", 1,   true, false, "position based dynamics: sweeps over the rows instead of a solve",
      false,  true};
  static std::string refusal(const System&) { return {}; }

  Xpbd(const System& system, const IntegratorOptions& options) : system_(&system), options_(options) {}
  Status prepare();
  Status step(double dt, State& state, History& history, EnergyLedger* ledger);
  const StepCounts& counts() const { return counts_; }
  long sweeps() const { return sweeps_; }  ///< done since prepare()

 private:
  Status substep(double dt, double closing, State& state, EnergyLedger* ledger);
  Status predict(double dt, const State& state);
  void remember(double dt, double closing, const VectorXd& q);
  Status sweep_current(double dt, const State& start);
  Status sweep_frozen(double dt, const State& start);
  void keep_books(double dt, const State& start, EnergyLedger& ledger) const;

  const System* system_;
  IntegratorOptions options_;
  RowSweep sweep_;
  Kkt kkt_;
  StepRows frozen_;
  std::vector<int> order_;  // rows as swept
  State next_, before_, at_;
  VectorXd v_start_;  // v_n after the gyroscopic step
  VectorXd remembered_, y_, impulse_;
  bool books_ = false;
  long sweeps_ = 0;
  StepCounts counts_;
};

}  // namespace feder
