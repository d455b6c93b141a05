#pragma once

#include <chrono>
#include <string>
#include <string_view>

namespace feder::experiments {

/// One line on stderr with rate and remaining time, redrawn in place. Writes nothing at all unless stderr is
/// a terminal.
class Progress {
 public:
  explicit Progress(bool quiet = false);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Begins counting `total` units of work.
  void start(long total);
  /// One more unit is done; `label` names it.
  void advance(std::string_view label = {});
  /// Removes the line. Called by whoever prints something else.
  void clear();

  /// The text of the line: "  7/20  35 %  1.2 /s  11 s left  chain". `seconds` is the time since start().
  static std::string line(long done, long total, double seconds, std::string_view label);

 private:
  using Clock = std::chrono::steady_clock;
  bool enabled_;
  bool visible_ = false;
  long done_ = 0;
  long total_ = 0;
  Clock::time_point begin_ = Clock::now();
  Clock::time_point drawn_ = {};
};

}  // namespace feder::experiments
