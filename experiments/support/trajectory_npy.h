#pragma once

#include <cstdint>
#include <string>

#include "experiments/support/frame.h"
#include "experiments/support/text_buffer.h"
#include "models/scene_file/scene.h"

namespace feder::experiments {

/// trajectory.npy: the numbers of trajectory.csv as a float64 array (frames, columns), NumPy format 1.0. The
/// number of frames stands in a field of fixed width, so that it can be set when a run has ended.
class TrajectoryNpy {
 public:
  explicit TrajectoryNpy(const Scene& scene);

  static std::string name() { return "trajectory.npy"; }
  std::string start(std::int64_t frames) const;
  static void add(const Frame& frame, TextBuffer& text);
  static std::string end() { return {}; }

 private:
  std::int64_t columns_;
};

}  // namespace feder::experiments
