// Random numbers that are the same with every standard library.
#pragma once

#include <cstdint>

#include "engine/state.h"

namespace feder {

/// SplitMix64: a counter-based stream per seed.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  /// In [low, high).
  double uniform(double low = -1.0, double high = 1.0) {
    return low + (high - low) * (static_cast<double>(bits() >> 11) * 0x1p-53);
  }
  /// In [0, count).
  int below(int count) { return static_cast<int>(bits() % static_cast<std::uint64_t>(count)); }
  Vector3d vector(double size = 1.0) {
    const double x = uniform(-size, size), y = uniform(-size, size);
    return {x, y, uniform(-size, size)};
  }
  VectorXd numbers(int count, double size = 1.0) {
    VectorXd x(count);
    for (int i = 0; i < count; ++i) x[i] = uniform(-size, size);
    return x;
  }

 private:
  std::uint64_t state_;
};

}  // namespace feder
