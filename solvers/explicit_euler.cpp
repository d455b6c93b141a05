// Explicit Euler. Its ledger: dK = dt f.(v + v')/2 exactly, since v' - v = dt M^-1 f.
#include "solvers/explicit_euler.h"

#include "solvers/impulse_ledger.h"

namespace feder {

Status ExplicitEuler::step(double dt, State& state, History& history, EnergyLedger* ledger) {
  const System& s = *system_;
  if (Status status = evaluate_forces(s, state, force_); !status.ok()) return status;
  add_gyroscopic_torques(s, state.v, force_);
  ++counts_.steps, ++counts_.force_evaluations;
  ImpulseLedger record(s, state, ledger);
  if (ledger) record.kick(dt, state, force_, state.v, state.v + dt * s.inverse_mass.cwiseProduct(force_));
  advance(s, dt, state.v, state.q, state.q, rotation_update_);
  state.v.array() += dt * s.inverse_mass.array() * force_.array();
  state.t += dt;
  drive(s, state);
  history.force.resize(0);
  record.close(state);
  return {};
}

}  // namespace feder
