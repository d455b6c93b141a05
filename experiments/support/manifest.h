#pragma once

#include <chrono>
#include <string>

#include "experiments/support/context.h"
#include "experiments/support/experiment.h"
#include "experiments/support/options.h"

namespace feder::experiments {

/// How a run ended.
struct Outcome {
  std::string status;  ///< to_string(StatusCode), or "internal_error"
  std::string reason;
  std::chrono::system_clock::time_point started;
  double wall_seconds = 0;
};

/// The text of manifest.json: everything needed to run the experiment again and to judge its numbers.
std::string manifest_json(const ExperimentInfo& info, const Options& options, const Context& context,
                          const Outcome& outcome);

/// "2024-05-17T09:30:00Z".
std::string utc_time(std::chrono::system_clock::time_point time);

/// Model name of the processor, "unknown" if the system does not tell.
std::string cpu_model();

}  // namespace feder::experiments
