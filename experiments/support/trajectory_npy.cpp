#include "experiments/support/trajectory_npy.h"

#include <fmt/format.h>

#include <bit>

namespace feder::experiments {

static_assert(std::endian::native == std::endian::little, "the file says '<f8'");

TrajectoryNpy::TrajectoryNpy(const Scene& scene)
    : columns_(1 + scene.model.state.q.size() + scene.model.state.v.size()) {}

std::string TrajectoryNpy::start(std::int64_t frames) const {
  // magic, version 1.0, length of the rest as two bytes, then a dictionary that ends at a multiple of 64
  constexpr std::size_t kLength = 128, kBefore = 10;
  std::string text("\x93NUMPY\x01\x00", 8);
  text += static_cast<char>(kLength - kBefore);
  text += '\0';
  text += fmt::format("{{'descr': '<f8', 'fortran_order': False, 'shape': ({:19}, {}), }}", frames, columns_);
  text.resize(kLength - 1, ' ');
  return text + '\n';
}

void TrajectoryNpy::add(const Frame& frame, TextBuffer& text) {
  text.add_bytes(&frame.state.t, 1);
  text.add_bytes(frame.state.q.data(), frame.state.q.size());
  text.add_bytes(frame.state.v.data(), frame.state.v.size());
}

}  // namespace feder::experiments
