#pragma once

#include <string>

#include "experiments/support/frame.h"
#include "experiments/support/text_buffer.h"
#include "models/scene_file/scene.h"

namespace feder::experiments {

/// frames/frame_000012.vtu
std::string frame_path(std::int64_t index);

/// <scene>.pvd: which frame is which time. The scene's name with "_" for all that is no letter, digit, "-",
/// "_" or ".".
class Pvd {
 public:
  explicit Pvd(const Scene& scene);

  std::string name() const { return name_; }
  static std::string start(std::int64_t);
  static void add(const Frame& frame, TextBuffer& text);
  static std::string end() { return "</Collection>\n</VTKFile>\n"; }

 private:
  std::string name_;
};

}  // namespace feder::experiments
