#include "models/scene_file/diagnostics.h"

#include <algorithm>
#include <utility>

namespace feder {

Diagnostics::Diagnostics(std::string file, std::vector<std::string> changes)
    : file_(std::move(file)), changes_(std::move(changes)) {}

void Diagnostics::add(TextPlace place, const std::string& message) {
  problems_.push_back({place, message});
}

void Diagnostics::throw_if_any() const {
  if (problems_.empty()) return;
  std::vector<Problem> sorted = problems_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Problem& x, const Problem& y) {
    return std::pair(x.place.line, x.place.column) < std::pair(y.place.line, y.place.column);
  });
  std::string text;
  for (std::size_t i = 0; i < std::min(sorted.size(), kMostShown); ++i) {
    const auto& [place, message] = sorted[i];
    if (i > 0) text += '\n';
    if (place.line > 0)
      text += file_ + ":" + std::to_string(place.line) + ":" + std::to_string(place.column) + ": ";
    else
      text += "--set " + changes_.at(static_cast<std::size_t>(place.column) - 1) + ": ";
    text += message;
  }
  if (sorted.size() > kMostShown) text += "\nand " + std::to_string(sorted.size() - kMostShown) + " more";
  throw SceneError(text);
}

}  // namespace feder
