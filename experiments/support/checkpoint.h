#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "engine/state.h"
#include "models/scene_file/scene.h"

namespace feder::experiments {

/// How far a growing file had been written and was on disk.
struct FilePosition {
  std::string name;         ///< final name, in the output folder
  std::int64_t length = 0;  ///< [bytes]
};

/// Everything a run needs to go on as if it had never stopped.
struct Checkpoint {
  std::uint64_t scene_hash = 0;
  std::int64_t frame = 0;  ///< frames written: the index of the next one
  std::int64_t step = 0;   ///< steps made
  State state = {};
  History history = {};
  std::vector<FilePosition> files = {};  ///< see FrameFiles::positions
};

/// Atomic. MisuseError where parse_checkpoint would refuse what is to be written, IoError.
void write_checkpoint(const std::filesystem::path& path, const Checkpoint& checkpoint);

/// Reads what write_checkpoint wrote. Anything else is an InputError "<place>: byte <offset>: <value>,
/// expected ..."; every change of a single byte is one. Memory stays proportional to the input's size.
Checkpoint parse_checkpoint(std::string_view bytes, const std::string& place);
/// Of a file; IoError if it cannot be read.
Checkpoint read_checkpoint(const std::filesystem::path& path);

/// InputError unless the checkpoint is of the scene with this hash and its vectors have the scene's sizes.
void require_checkpoint_of(const Scene& scene, std::uint64_t scene_hash, const Checkpoint& checkpoint,
                           const std::string& place);

}  // namespace feder::experiments
