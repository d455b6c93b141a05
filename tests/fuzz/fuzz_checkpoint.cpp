// Any bytes are an InputError or a checkpoint; once as they are, once with the size and the checksum put
// right, so that what lies behind these is reached.
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>

#include "experiments/support/checkpoint.h"
#include "models/scene_file/scene_file.h"

namespace {

using namespace feder;
using namespace feder::experiments;

void parse(const std::string& bytes) {
  static const Scene scene =
      read_scene_text(
          "end_time = 1\n[[particle]]\nname = 'p'\nmass = 1\nposition = [1, 0, 0]\n[[spring]]\n"
          "between = ['p', [0, 0, 0]]\nstiffness = 1\n",
          "scene.toml", ".")
          .scene;
  try {
    const Checkpoint checkpoint = parse_checkpoint(bytes, "checkpoint.bin");
    if (!checkpoint.state.q.allFinite() || !std::isfinite(checkpoint.state.t) || checkpoint.frame < 0)
      __builtin_trap();
    require_checkpoint_of(scene, checkpoint.scene_hash, checkpoint, "checkpoint.bin");
  } catch (const InputError&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::string bytes(reinterpret_cast<const char*>(data), size);
  parse(bytes);
  if (size < 24) return 0;
  const std::uint64_t length = size;
  std::memcpy(bytes.data(), "FEDERCP2", 8);
  std::memcpy(bytes.data() + 8, &length, 8);
  std::uint64_t sum = 14695981039346656037ULL;
  for (std::size_t i = 0; i < size - 8; ++i)
    sum = (sum ^ static_cast<unsigned char>(bytes[i])) * 1099511628211ULL;
  std::memcpy(bytes.data() + size - 8, &sum, 8);
  parse(bytes);
  return 0;
}
