#include "experiments/support/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace feder::experiments {
namespace {

std::string duration(double seconds) {
  if (seconds < 100) return fmt::format("{:.0f} s", seconds);
  if (seconds < 6000) return fmt::format("{:.0f} min", seconds / 60);
  return fmt::format("{:.1f} h", seconds / 3600);
}

}  // namespace

Progress::Progress(bool quiet) : enabled_(!quiet && ::isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  clear();
}

void Progress::start(long total) {
  done_ = 0;
  total_ = total;
  begin_ = Clock::now();
}

void Progress::advance(std::string_view label) {
  ++done_;
  // Ten redraws a second are enough for the eye and cost nothing.
  const Clock::time_point now = Clock::now();
  if (!enabled_ || now - drawn_ < std::chrono::milliseconds(100)) return;
  drawn_ = now;
  visible_ = true;
  const double seconds = std::chrono::duration<double>(now - begin_).count();
  std::fputs(("\r\033[K" + line(done_, total_, seconds, label)).c_str(), stderr);
  std::fflush(stderr);
}

void Progress::clear() {
  if (!visible_) return;
  std::fputs("\r\033[K", stderr);
  std::fflush(stderr);
  visible_ = false;
}

std::string Progress::line(long done, long total, double seconds, std::string_view label) {
  const double rate = seconds > 0 ? static_cast<double>(done) / seconds : 0;
  std::string text =
      total > 0 ? fmt::format("  {}/{}  {} %", done, total, 100 * done / total) : fmt::format("  {}", done);
  text += fmt::format("  {:.3g} /s", rate);
  if (total > done && rate > 0) text += "  " + duration(static_cast<double>(total - done) / rate) + " left";
  if (!label.empty()) text += "  " + std::string(label.substr(0, 40));
  return text;
}

}  // namespace feder::experiments
