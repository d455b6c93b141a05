#pragma once

#include "engine/energy.h"
#include "engine/kkt.h"

namespace feder {

/// The energy ledger of explicit methods. A kick M (v_after - v_before) = dt F does the work dt F.(v_before +
/// v_after)/2 exactly; it is split into external, drag and row parts. Does nothing if the ledger is null.
class ImpulseLedger {
 public:
  /// Opens the books at `before`.
  ImpulseLedger(const System& system, const State& before, EnergyLedger* ledger);
  /// One kick of length dt by `force`, evaluated at `at` (position, time and the velocity drag acts on).
  void kick(double dt, const State& at, const VectorXd& force, const VectorXd& v_before,
            const VectorXd& v_after);
  /// Closes them at `after`.
  void close(const State& after);

 private:
  const System& system_;
  EnergyLedger* ledger_;
  VectorXd v_before_;
};

}  // namespace feder
