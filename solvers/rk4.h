#pragma once

#include <array>

#include "solvers/integrator.h"

namespace feder {

/// The classical Runge-Kutta method of order 4 on (q, v) (notes B3). Stable on the imaginary axis up to omega
/// dt = 2 sqrt 2.
class Rk4 {
 public:
  static constexpr IntegratorInfo kInfo{"rk4", 4, false, false, "four right-hand sides per step; order 4"};
  static std::string refusal(const System& system) { return refuse_hard_rows(system, kInfo.name); }

  Rk4(const System& system, const IntegratorOptions&) : system_(&system) {}
  Status prepare() { return {}; }
  Status step(double dt, State& state, History& history, EnergyLedger* ledger);
  const StepCounts& counts() const { return counts_; }

 private:
  void drive(State& at) const;

  const System* system_;
  State stage_;
  std::array<VectorXd, 4> force_, rate_;  // of v and of q
  StepCounts counts_;
};

}  // namespace feder
