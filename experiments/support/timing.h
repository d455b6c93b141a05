#pragma once

#include <algorithm>
#include <chrono>
#include <limits>
#include <vector>

namespace feder::experiments {

/// Seconds on a clock that never goes back.
class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(Clock::now() - begin_).count(); }
  void restart() { begin_ = Clock::now(); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point begin_ = Clock::now();
};

/// Smallest of `repeats` durations; `measure` returns the seconds of one run. Noise only ever adds time.
template <typename Measure>
double best_of(int repeats, Measure&& measure) {
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < repeats; ++i) best = std::min(best, static_cast<double>(measure()));
  return best;
}

/// Middle value, mean of the two middle ones for an even count, NaN for none.
inline double median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

}  // namespace feder::experiments
