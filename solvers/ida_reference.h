#pragma once

#include <string>

#include "engine/status.h"
#include "engine/system.h"
#include "solvers/ida_system.h"

namespace feder {

/// Local error bounds and budgets of the judge. The absolute tolerance of the multipliers only ends Newton
/// iterations: they are left out of the error test.
struct IdaOptions {
  double relative_tolerance = 1e-9;
  double position_tolerance = 1e-11;   ///< [m]
  double velocity_tolerance = 1e-10;   ///< [m/s]
  double multiplier_tolerance = 1e-3;  ///< [N], [N m] for bending
  IdaForm form = IdaForm::kAutomatic;
  long max_steps = 1'000'000;
  double max_seconds = 60.0;  ///< wall clock

  /// All four tolerances times `factor`.
  IdaOptions loosened(double factor) const;
};

struct IdaResult {
  Status status;
  State state;  ///< at end_time if ok, otherwise where IDA stopped
  long steps = 0;
  double seconds = 0.0;
  std::string form;  ///< "ode" or "compliance"
};

/// ODE up to omega_max (end_time - t) = kLargestOdePhase [rad], compliance above. The ODE form needs about
/// two steps per radian of the fastest frequency even where it is not excited (40 000 at the border); the
/// compliance form steps over it, at a position error some 100 times larger for the same tolerance. ODE also
/// where the frequency cannot be predicted (degenerate state).
IdaForm choose_ida_form(const System& system, const State& initial, double end_time);
inline constexpr double kLargestOdePhase = 2e4;

/// Integrates with SUNDIALS IDA (variable-order BDF, KLU, analytic Jacobian) from `initial` exactly to
/// `end_time` [s].
///
/// kRefused: a hard row (index 3; IDA's initialiser would not notice), a non-finite or negative option, a
/// non-finite initial state, end_time < initial.t. kNonFinite or kSingular, with node or row: a force or row
/// stopped the way forward. kLimitReached: step or wall-clock budget. kStepTooSmall, kNotConverged: IDA's own
/// verdicts.
IdaResult ida_solve(const System& system, const State& initial, double end_time,
                    const IdaOptions& options = {});

}  // namespace feder
