#pragma once

#include <optional>

#include "solvers/contact/contact_step.h"
#include "solvers/integrator.h"

namespace feder {

/// Implicit Euler with one linearisation at q_n (notes E8): the step matrix with sigma = dt^2, rho = dt, p =
/// M v + dt f, r = phi/(dt + tau); q' = q + dt v'. Works by every route.
/// A hard row closes its gap within the longer of this and the last step: a short step after a long one would
/// turn what the long one left into a kick.
///   kOff      the notes' step: force directions stay frozen; stable only below 2/sqrt(lambda_max(Kg - Km,
///   M)) kClamped  with the positive semidefinite part of dt^2 Kg in Mt, lambda of the last step
template <GeometricStiffness kKind>
class LinearImplicitEuler {
 public:
  static constexpr bool kGeometric = kKind != GeometricStiffness::kOff;
  static constexpr IntegratorInfo kInfo{
      kGeometric ? "implicit_euler_geometric" : "implicit_euler_notes",
      1,
      true,
      false,
      kGeometric ? "one linear solve per step, with clamped geometric stiffness"
                 : "one linear solve per step, the notes' step without geometric stiffness",
      true};
  static std::string refusal(const System&) { return {}; }

  LinearImplicitEuler(const System& system, const IntegratorOptions& options)
      : system_(&system), solver_(options.route, options.solve), rotation_update_(options.rotation_update) {}
  Status prepare();
  Status step(double dt, State& state, History& history, EnergyLedger* ledger);
  const StepCounts& counts() const { return counts_; }
  const LinearSolver& solver() const { return solver_; }
  LinearSolver& solver() { return solver_; }
  const StepTimes& times() const { return times_; }
  void reset_times();
  const Kkt& kkt() const { return kkt_; }
  /// Null before prepare() and in scenes without colliders.
  ContactStep* contacts() { return contacts_ ? &*contacts_ : nullptr; }
  const SolveReport& report() const { return report_; }

 private:
  Status linearise(double dt, const State& state, const History& history);

  const System* system_;
  LinearSolver solver_;
  Kkt kkt_;
  std::optional<ContactStep> contacts_;
  State at_;
  RotationUpdate rotation_update_;
  VectorXd v_, y_, lambda_;
  VectorXd v_start_;                 // with bodies: v_n after the gyroscopic step
  double dt_ = 0.0, closing_ = 0.0;  // the steps rate_ belongs to
  VectorXd memory_, rate_;           // System::memory and (1 - memory) / dt per row, hard rows: / closing_
  SolveReport report_;
  StepCounts counts_;
  StepTimes times_;
};

using ImplicitEulerNotes = LinearImplicitEuler<GeometricStiffness::kOff>;
using ImplicitEulerGeometric = LinearImplicitEuler<GeometricStiffness::kClamped>;

}  // namespace feder
