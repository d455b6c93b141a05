#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "solvers/integrators.h"

namespace feder {

/// Looks for divergence: kinetic energy against what the scene can give: what it had, what its springs held,
/// the work of external forces over the way moved, and (for scenes at rest) crossing itself once during the
/// run.
class DivergenceCheck {
 public:
  /// `span` is the length of the whole run [s]; `factor` as RunOptions::divergence.
  DivergenceCheck(const System& system, const State& start, double span, double factor = 1e6);
  Status operator()(const State& state);

 private:
  const System& system_;
  VectorXd start_, force_;
  double factor_, scale_;
};

struct RunOptions {
  double dt = 0.0;           ///< step [s]
  double end_time = 0.0;     ///< [s], later than the state's time
  double max_seconds = 0.0;  ///< wall-clock budget [s], 0: none
  double divergence = 1e6;  ///< stop when kinetic energy exceeds this many times the scene's own energy scale
  std::vector<EnergyLedger>* ledgers = nullptr;  ///< one per step if not null
  /// Called after every step; false ends the run with kInterrupted.
  std::function<bool(const State&, const History&)> observer = {};
  /// For a run in pieces: the check of the whole run instead of one of its own (null: its own) ...
  DivergenceCheck* check = nullptr;
  bool prepare = true;  ///< ... and false where the integrator goes on from the piece before
};

struct RunResult {
  Status status;
  std::int64_t steps = 0;
  double seconds = 0.0;  ///< of the step loop alone
};

/// Number of steps of length dt from t0 to end; the last may be shorter. Throws InputError for dt that is not
/// finite and > 0, longer than the interval, or so small that steps exceed 2^53.
std::int64_t step_count(double t0, double end, double dt);

/// What the clock's rounding makes of the number of steps and of the last one, as a fraction of dt: a rest of
/// a billionth of a step is no step, and late in a long run the clock itself is coarser than that.
double step_rounding(double t0, double end, double dt);

/// The longest step <= dt that fills the interval in equal steps; dt itself where it does up to rounding.
double equal_step(double t0, double end, double dt);

/// Runs from state.t to options.end_time with fixed steps. Times are t0 + n dt in one rounding; the last step
/// lands on the end exactly. The run ends at the first failure, with its status and the last good state.
/// Divergence is looked for every 8 steps. Prepares (analyses) the integrator first.
RunResult simulate(const System& system, Integrator& integrator, State& state, History& history,
                   const RunOptions& options);

/// Step-size control by step doubling (notes B4) over any integrator.
struct AdaptiveOptions {
  double tolerance = 1e-6;  ///< of the estimate below [m]; the error at the end is proportional to it
  double first_dt = 1e-3;   ///< [s]
  double least_dt = 1e-12;  ///< below: kStepTooSmall [s]
  double end_time = 0.0;    ///< [s]
  /// On: the error per step is held at the tolerance and the run advances with y + (y_2half - y_full)/(2^p -
  /// 1), one order higher. Refused with hard rows, which extrapolation would violate. Off, and for symmetric
  /// methods (where extrapolation gains two orders): the error per unit of the run's length is held at the
  /// tolerance.
  bool extrapolate = true;
  std::int64_t most_steps = 100'000'000;
  std::function<bool(const State&, double dt, double error)> observer = {};  ///< after every accepted step
};

struct AdaptiveResult {
  Status status;
  std::int64_t accepted = 0, rejected = 0;
  double seconds = 0.0;
  double smallest_dt = 0.0, largest_dt = 0.0;
};

AdaptiveResult simulate_adaptive(const System& system, Integrator& integrator, State& state, History& history,
                                 const AdaptiveOptions& options);

/// Sum over the bodies of theta.I theta [kg m^2], theta the small turn from a to b: what their points move
/// apart, weighted by mass.
double rotation_error(const System& system, const VectorXd& q_a, const VectorXd& q_b);

/// Estimate of the local error after one full and two half steps of a method of order p: |y_2half - y_full| /
/// (2^p - 1), in mass-weighted rms of position and dt times velocity [m].
double doubling_error(const System& system, const State& full, const State& halves, double dt, int order);

}  // namespace feder
