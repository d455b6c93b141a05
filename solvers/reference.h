#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "solvers/ida_reference.h"

namespace feder {

/// How a reference is made. Defaults: IDA at 1e-9 and 1e-11.
struct ReferenceOptions {
  /// The tighter of the two runs; the other has all tolerances times 100. Budgets hold for each run, explicit
  /// ones included.
  IdaOptions judge = {.relative_tolerance = 1e-11, .position_tolerance = 1e-13, .velocity_tolerance = 1e-12};
  int most_ida_unknowns = 3000;    ///< above (counted as 2 x free coordinates): explicit path
  double explicit_fraction = 0.1;  ///< coarse explicit step as a fraction of the stability limit
  /// Hard rows or bodies: steps are halved until two runs agree to this fraction of the scene's size ...
  double halving_accuracy = 1e-7;
  double halving_seconds = 30.0;  ///< ... or all runs together took this long [s]
  bool use_cache = true;
  std::filesystem::path
      cache_folder;  ///< empty: $XDG_CACHE_HOME/feder/references or ~/.cache/feder/references
};

/// The judge's answer at the end time and what it is worth.
struct Reference {
  Status status;
  State state;
  double error = 0.0;  ///< [m] position_error between the two tolerances or step sizes
  std::string method;  ///< "ida ode, relative tolerance 1e-09 and 1e-11", "leapfrog, dt 0.001 and 0.0005"
  bool from_cache = false;
};

/// sqrt(sum m |dx|^2 / sum m) over the particles that can move and the points of the bodies [m].
double position_error(const System& system, const State& a, const State& b);

/// The trajectory's end by IDA at two tolerances; on scenes too large for it, or where its budget runs out
/// (recorded in `method`), by leapfrog (RK4 with damping, drag or a user force) at dt and dt/2, not
/// extrapolated. The state is that of the finer run, the error the difference of the two, which is mostly
/// that of the coarser. Scenes with hard rows or bodies have no predicted step: leapfrog (RATTLE), or RK4 for
/// bodies without hard rows, with steps halved until two runs agree. Successful references of scenes without
/// a user force are cached under a hash of every number that decides them; a damaged or unwritable cache
/// costs time, never the answer.
Reference make_reference(const System& system, const State& initial, double end_time,
                         const ReferenceOptions& options = {});

/// The three paths by themselves, without cache.
Reference ida_reference(const System& system, const State& initial, double end_time,
                        const ReferenceOptions& options = {});
Reference explicit_reference(const System& system, const State& initial, double end_time,
                             const ReferenceOptions& options = {});

Reference halving_reference(const System& system, const State& initial, double end_time,
                            const ReferenceOptions& options = {});

/// Where the cache keeps this reference; nothing if it cannot be cached.
std::optional<std::filesystem::path> reference_cache_file(const System& system, const State& initial,
                                                          double end_time,
                                                          const ReferenceOptions& options = {});

}  // namespace feder
