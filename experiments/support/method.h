#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "models/scene_file/scene_file.h"
#include "solvers/integrator.h"

namespace feder::experiments {

/// The [method] table of a scene file: how it is advanced.
struct Method {
  std::string integrator = "auto";  ///< "auto": what `explain` recommends
  double dt = 0.0;                  ///< [s], 0: what `explain` recommends
  double tolerance = 0.0;           ///< of step doubling [m], 0: fixed steps
  double max_seconds = 0.0;         ///< wall-clock budget of the step loop [s], 0: none
  double divergence = 1e6;          ///< see RunOptions
  IntegratorOptions options = {};
};

/// The [output] table: when to look, and what to write down.
struct Output {
  double interval = 0.0;           ///< [s], 0: a hundredth of the run
  std::vector<double> times = {};  ///< [s], ascending; instead of an interval
  std::vector<std::string> files = {"states", "energy"};
  int checkpoint_frames = 0;  ///< frames from one checkpoint to the next, 0: about every 200 steps
};

/// What `files` may hold.
const std::vector<std::string>& output_files();

/// Their keys, for the reference page.
std::vector<TableInfo> method_tables();
/// Readers of both for SceneOptions::others; they refuse what frame_times would. `method` and `output` must
/// outlive the reading.
std::vector<OtherTable> method_readers(Method& method, Output& output);

/// Times of the frames from 0 to end_time, both included [s]. InputError for times outside or not ascending,
/// or more than kMostFrames.
std::vector<double> frame_times(const Output& output, double end_time);
/// The checks of frame_times alone.
void require_frames(const Output& output, double end_time);
inline constexpr double kMostFrames = 1e7;

}  // namespace feder::experiments
