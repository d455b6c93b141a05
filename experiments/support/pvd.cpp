#include "experiments/support/pvd.h"

#include <fmt/format.h>

namespace feder::experiments {

std::string frame_path(std::int64_t index) {
  return fmt::format("frames/frame_{:06}.vtu", index);
}

Pvd::Pvd(const Scene& scene) : name_("scene") {
  const std::string kept = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_.";
  if (!scene.model.name.empty()) name_ = scene.model.name;
  for (char& c : name_)
    if (kept.find(c) == std::string::npos) c = '_';
  if (name_.front() == '.') name_.front() = '_';
  name_ += ".pvd";
}

std::string Pvd::start(std::int64_t) {
  return "<?xml version=\"1.0\"?>\n"
         "<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n";
}

void Pvd::add(const Frame& frame, TextBuffer& text) {
  text.add("<DataSet timestep=\"");
  text.add_number(frame.state.t);
  text.add("\" group=\"\" part=\"0\" file=\"" + frame_path(frame.index) + "\"/>\n");
}

}  // namespace feder::experiments
