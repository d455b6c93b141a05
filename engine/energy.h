#pragma once

#include "engine/system.h"

namespace feder {

/// 1/2 v^T M v [J].
double kinetic_energy(const System& system, const State& state);
/// 1/2 (v_after - v_before)^T M (v_after + v_before) [J]: the change of kinetic energy without cancellation.
double kinetic_energy_change(const System& system, const VectorXd& v_before, const VectorXd& v_after);
/// 1/2 phi^T D phi over the finite rows [J] (hard rows store nothing).
double row_energy(const System& system, const State& state);
/// -sum of constant forces . x (gravity included), and what user force, law springs and fluid have of an
/// energy [J].
double external_energy(const System& system, const State& state);
/// Sum of the three [J].
double total_energy(const System& system, const State& state);
/// Sum of m v [kg m/s].
Vector3d linear_momentum(const System& system, const State& state);
/// Sum of x cross m v about the origin [kg m^2/s].
Vector3d angular_momentum(const System& system, const State& state);

/// Where the energy of one step went. Every term is computed on its own route, so `imbalance` measures
/// rounding (and for Newton the residual left), not the definition. Implicit Euler (design.md section 1): E =
/// 1/2 v M v + U(rows),
///   dE = dt f.v' + y.(J v') - dt^2 v'.Kg v' - 1/2 |v'-v|_M^2 + dU,   with f counting drag at v' and y = dt
///   lambda.
/// Explicit methods: the impulse terms are taken with the mean velocity (v + v')/2, `numerical` is 0, see
/// each integrator.
struct EnergyLedger {
  double kinetic_change = 0.0;  ///< d(1/2 v M v)
  double row_change = 0.0;      ///< dU of the finite rows
  double external_work = 0.0;   ///< impulse of constant and user forces times velocity
  double drag_work = 0.0;       ///< the same for drag, <= 0 for implicit methods
  double row_work = 0.0;        ///< y.(J v'): what the rows gave to the velocities
  double geometric_work = 0.0;  ///< -dt^2 v'.Kg v'
  double numerical = 0.0;       ///< -1/2 |v'-v|_M^2, the numerical dissipation of implicit Euler
  double contact_work = 0.0;    ///< of contacts: what rebounds give back less what friction takes

  /// d(kinetic) minus its sources: 0 up to rounding.
  double imbalance() const {
    return kinetic_change -
           (external_work + drag_work + row_work + geometric_work + numerical + contact_work);
  }
  /// Sum of the magnitudes of all terms, the scale of `imbalance`.
  double magnitude() const;
  /// Change of kinetic plus row energy.
  double energy_change() const { return kinetic_change + row_change; }
};

}  // namespace feder
