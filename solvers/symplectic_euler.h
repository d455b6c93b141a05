#pragma once

#include <memory>

#include "solvers/integrator.h"

namespace feder {

/// v' = v + dt M^-1 F(q, v, t), then q' = q + dt v' (notes B2): explicit Euler with the new velocity.
/// Symplectic without damping, stable up to omega dt = 2. An incompressible fluid (engine/fluid/fluid.h) is
/// held after the kick by its density rows, pushes only: phi(q) + dt phidot(v') <= 0, closed directly to 1e-9
/// (route auto or dual; kNotConverged where no v' closes them, as in a tank too full) or by `sweeps` sweeps
/// (route sweeps). What density is left over is of second order in dt v'.
class SymplecticEuler {
 public:
  static constexpr IntegratorInfo kInfo{
      .name = "symplectic_euler",
      .order = 1,
      .implicit = false,
      .symmetric = false,
      .summary = "right-hand side once per step; symplectic without damping; takes incompressible fluids",
      .incompressible = true};
  static std::string refusal(const System& system) { return refuse_hard_rows(system, kInfo.name); }

  SymplecticEuler(const System& system, const IntegratorOptions& options);
  SymplecticEuler(SymplecticEuler&&) noexcept;
  SymplecticEuler& operator=(SymplecticEuler&&) noexcept;
  ~SymplecticEuler();
  Status prepare();
  Status step(double dt, State& state, History& history, EnergyLedger* ledger);
  const StepCounts& counts() const { return counts_; }

 private:
  Status hold_density(double dt, const State& state);

  struct Projection;  // onto the density rows
  const System* system_;
  IntegratorOptions options_;
  std::unique_ptr<Projection> projection_;
  VectorXd force_, v_next_;
  StepCounts counts_;
};

}  // namespace feder
