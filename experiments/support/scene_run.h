#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>

#include "engine/status.h"
#include "experiments/support/checkpoint.h"
#include "experiments/support/frame_files.h"
#include "experiments/support/method.h"
#include "experiments/support/progress.h"

namespace feder::experiments {

/// What a run leaves beside its files. NaN: not known.
struct RunReport {
  Status status;
  std::string integrator, route;
  double dt = std::numeric_limits<double>::quiet_NaN();  ///< largest step used [s]
  std::int64_t steps = 0, frames = 0;
  State state;                                                     ///< the last good one
  double energy_drift = std::numeric_limits<double>::quiet_NaN();  ///< of the scene's energy scale
  double seconds = 0.0;                                            ///< of the step loop
  double seconds_assemble = 0.0, seconds_factor = 0.0, seconds_solve = 0.0, seconds_output = 0.0;
};

/// How a scene is run. The method is resolved: an integrator by name, dt > 0.
struct RunRequest {
  const Scene& scene;
  const Method& method;
  const Output& output;
  std::filesystem::path folder;  ///< exists
  std::uint64_t scene_hash = 0;  ///< of everything that decides the result
  bool resume = false;           ///< go on from the folder's checkpoint
  /// Called after every frame, with their number; false ends the run as Ctrl-C does.
  std::function<bool(std::int64_t frames)> observer = {};
};

inline constexpr const char* kCheckpointFile = "checkpoint.bin";

/// Throws InputError unless method.dt can step from frame to frame, see step_count.
void require_steps(const Method& method, const std::vector<double>& times);

/// Steps the scene through its frames and writes them. Between two frames the steps are equal and not longer
/// than method.dt. Every so many frames, resumed or not, the integrator is made anew: that is why a resumed
/// run is bitwise the uninterrupted one. There a checkpoint is written, without output.checkpoint_frames only
/// if the one before is a second old: waiting for the disk must not cost more than the steps. A run that ends
/// early writes the last one still. Ctrl-C ends it after the step, with kInterrupted and complete files;
/// where the disk refuses the status is kIoError and the frames before stay readable. Throws InputError for a
/// checkpoint of another run, IoError where there is none.
RunReport run_scene(const RunRequest& request, Progress& progress);

}  // namespace feder::experiments
