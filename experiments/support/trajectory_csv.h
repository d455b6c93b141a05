#pragma once

#include <string>

#include "experiments/support/frame.h"
#include "experiments/support/text_buffer.h"
#include "models/scene_file/scene.h"

namespace feder::experiments {

/// trajectory.csv: one line per time with t, q and v, see trajectory_columns.
class TrajectoryCsv {
 public:
  explicit TrajectoryCsv(const Scene& scene);

  static std::string name() { return "trajectory.csv"; }
  std::string start(std::int64_t) const { return header_; }
  static void add(const Frame& frame, TextBuffer& text);
  static std::string end() { return {}; }

 private:
  std::string header_;
};

}  // namespace feder::experiments
