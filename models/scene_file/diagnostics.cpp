#include "models/scene_file/diagnostics.h"

#include <algorithm>
#include <utility>

namespace feder {
namespace {

bool before(TextPlace x, TextPlace y) {
  return std::pair(x.line, x.column) < std::pair(y.line, y.column);
}

std::string on_one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = '?';
  return text;
}

// What was typed, not all of it where it is long.
std::string start_of(const std::string& change) {
  constexpr std::size_t kLongest = 100;
  return on_one_line(change.substr(0, kLongest)) + (change.size() > kLongest ? "..." : "");
}

}  // namespace

Diagnostics::Diagnostics(std::string file, std::vector<std::string> changes)
    : file_(on_one_line(std::move(file))), changes_(std::move(changes)) {}

void Diagnostics::add(TextPlace place, const std::string& message) {
  ++count_;
  if (!shows(place)) return;
  const auto after = std::upper_bound(problems_.begin(), problems_.end(), place,
                                      [](TextPlace at, const Problem& p) { return before(at, p.place); });
  problems_.insert(after, {place, on_one_line(message)});
  if (problems_.size() > kMostShown) problems_.pop_back();
}

bool Diagnostics::shows(TextPlace place) const {
  return problems_.size() < kMostShown || before(place, problems_.back().place);
}

void Diagnostics::throw_if_any() const {
  if (empty()) return;
  std::string text;
  for (const auto& [place, message] : problems_) {
    if (!text.empty()) text += '\n';
    if (place.line > 0)
      text += file_ + ":" + std::to_string(place.line) + ":" + std::to_string(place.column) + ": ";
    else
      text += "--set " + start_of(changes_.at(static_cast<std::size_t>(place.column) - 1)) + ": ";
    text += message;
  }
  if (count_ > problems_.size()) text += "\nand " + std::to_string(count_ - problems_.size()) + " more";
  throw SceneError(text);
}

}  // namespace feder
