#pragma once

#include <string>
#include <vector>

#include "experiments/support/frame.h"
#include "experiments/support/text_buffer.h"
#include "models/scene_file/scene.h"

namespace feder::experiments {

/// rows.csv: one line per time and scalar row of each SceneRow, with its violation phi and its force lambda
/// (units: engine/README.md), which is empty before the first step.
class RowsCsv {
 public:
  explicit RowsCsv(const Scene& scene);

  static std::string name() { return "rows.csv"; }
  static std::string start(std::int64_t) { return "t,name,type,component,phi,lambda\n"; }
  void add(const Frame& frame, TextBuffer& text);
  static std::string end() { return {}; }

 private:
  const Scene* scene_;
  std::vector<std::string> names_;  ///< ",name,type," per SceneRow
  TextBuffer time_;
};

}  // namespace feder::experiments
