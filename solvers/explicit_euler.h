#pragma once

#include "solvers/integrator.h"

namespace feder {

/// q' = q + dt v, v' = v + dt M^-1 f(q, v, t) (notes B1).
class ExplicitEuler {
 public:
  static constexpr IntegratorInfo kInfo{"explicit_euler", 1, false, false,
                                        "right-hand side once per step; gains energy on undamped springs"};
  static std::string refusal(const System& system) { return refuse_hard_rows(system, kInfo.name); }

  ExplicitEuler(const System& system, const IntegratorOptions& options)
      : system_(&system), rotation_update_(options.rotation_update) {}
  Status prepare() { return {}; }
  Status step(double dt, State& state, History& history, EnergyLedger* ledger);
  const StepCounts& counts() const { return counts_; }

 private:
  const System* system_;
  RotationUpdate rotation_update_;
  VectorXd force_;
  StepCounts counts_;
};

}  // namespace feder
