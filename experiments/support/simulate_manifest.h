#pragma once

#include <chrono>
#include <string>

#include "experiments/support/program.h"
#include "experiments/support/scene_run.h"
#include "experiments/support/simulate_options.h"
#include "solvers/reference.h"

namespace feder::experiments {

/// The copy of the scene file beside a manifest.
inline constexpr const char* kSceneCopy = "scene.toml";

/// Everything manifest.json of `simulate` says.
struct SimulateRecord {
  const SimulateOptions& options;
  const Method& method;  ///< as resolved
  const Scene& scene;
  std::string scene_hash;
  const RunReport& report;
  const Reference* reference;  ///< null: not asked for, or the run failed
  Ending ending;
  std::chrono::system_clock::time_point started;
  double wall_seconds;
};
std::string manifest_json(const SimulateRecord& record);

/// FNV-1a of the last state, every bit of it, and of the counts of steps and frames.
std::string results_hash(const RunReport& report);

/// What to do again, from the manifest that options.rerun names: scene, settings, preset. Also the hash to
/// reach. Throws InputError for a file that is no manifest of `simulate`, IoError.
struct Rerun {
  SimulateOptions options;
  std::filesystem::path folder;  ///< where the scene's mesh files are looked for
  std::string results_hash;
};
Rerun read_rerun(const SimulateOptions& options);

}  // namespace feder::experiments
