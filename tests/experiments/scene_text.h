#pragma once

#include <string>

#include "experiments/support/files.h"
#include "experiments/support/method.h"
#include "experiments/support/scene_run.h"
#include "models/scene_file/scene_file.h"

namespace feder::experiments {

/// What `simulate` reads from a scene file.
struct ReadScene {
  SceneFile file;
  Method method;
  Output output;

  Scene& scene() { return file.scene; }
};

inline void read_into(ReadScene& read, const std::string& text) {
  read.file = read_scene_text(text, "test.toml", ".", {.others = method_readers(read.method, read.output)});
}

inline ReadScene scene_from(const std::string& text) {
  ReadScene read;
  read_into(read, text);
  return read;
}

/// A run of it in a folder.
inline RunReport run_in(const std::filesystem::path& folder, ReadScene& read, bool resume = false,
                        std::function<bool(std::int64_t)> observer = {}) {
  Progress silent(true);
  create_folder(folder);
  return run_scene({read.scene(), read.method, read.output, folder, 1, resume, std::move(observer)}, silent);
}

inline const std::string kEveryFile =
    "files = [\"states\", \"trajectory\", \"npy\", \"rows\", \"energy\", \"vtu\"]\n";

}  // namespace feder::experiments
