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
  std::filesystem::path file;  ///< the scene's own, where its mesh files are, too
  const Output& output;
  const Method& method;  ///< as resolved
  const Scene& scene;
  std::string scene_hash;
  const RunReport& report;
  const Reference* reference;  ///< null: not asked for, or the run failed
  Ending ending;
  const std::vector<std::string>& notes;  ///< of the reader
  std::chrono::system_clock::time_point started;
  double wall_seconds;
};
std::string manifest_json(const SimulateRecord& record);

/// FNV-1a of the last state, every bit of it, and of the counts of steps and frames.
std::string results_hash(const RunReport& report);

/// What to do again, from the manifest that options.rerun names: scene (the copy beside it), settings,
/// preset, threads. Without --out into "results/scenes/<name>_rerun", so that the manifest stays. Throws
/// InputError for a file that is no manifest of `simulate`, IoError.
struct Rerun {
  SimulateOptions options;
  std::filesystem::path file;  ///< where the copied scene came from
  std::string results_hash;    ///< to reach
};
Rerun read_rerun(const SimulateOptions& options);

}  // namespace feder::experiments
