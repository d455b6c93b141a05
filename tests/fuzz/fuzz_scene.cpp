// Any bytes are a scene or an InputError. Lines "#set key=value" at the start are given as --set.
#include <algorithm>
#include <cstdint>
#include <string>

#include "models/scene_file/scene_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace feder;
  const std::string text(reinterpret_cast<const char*>(data), size);
  const std::string set = "#set ";
  SceneOptions options{.others = {{"method", [](const Value&, Diagnostics&) {}}}};
  options.most_nodes = 500, options.most_rows = 5000;
  for (std::size_t at = 0; text.compare(at, set.size(), set) == 0;) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    options.changes.push_back(text.substr(at + set.size(), end - at - set.size()));
    if (end == text.size()) break;
    at = end + 1;
  }
  // counts of a catalogue model have limits of their own, too large for here
  if (text.find("model") != std::string::npos && text.find(':') != std::string::npos) return 0;
  try {
    (void)read_scene_text(text, "scene.toml", ".", options);
  } catch (const InputError&) {
  }
  return 0;
}
