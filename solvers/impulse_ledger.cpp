#include "solvers/impulse_ledger.h"

namespace feder {

ImpulseLedger::ImpulseLedger(const System& system, const State& before, EnergyLedger* ledger)
    : system_(system), ledger_(ledger) {
  if (!ledger_) return;
  *ledger_ = {};
  v_before_ = before.v;
  ledger_->row_change = -row_energy(system_, before);
}

void ImpulseLedger::kick(double dt, const State& at, const VectorXd& force, const VectorXd& v_before,
                         const VectorXd& v_after) {
  if (!ledger_) return;
  VectorXd external, mean = 0.5 * (v_before + v_after);
  for (int i : system_.masked) mean[i] = 0.0;
  evaluate_external_forces(system_, at, external);
  const VectorXd drag = -system_.forces.drag.cwiseProduct(at.v);
  ledger_->external_work += dt * external.dot(mean);
  ledger_->drag_work += dt * drag.dot(mean);
  ledger_->row_work += dt * (force - external - drag).dot(mean);
}

void ImpulseLedger::close(const State& after) {
  if (!ledger_) return;
  ledger_->kinetic_change = kinetic_energy_change(system_, v_before_, after.v);
  ledger_->row_change += row_energy(system_, after);
}

}  // namespace feder
