#pragma once

#include <cstdint>
#include <random>

#include "engine/kinematic_map.h"

namespace feder::experiments {

/// Random numbers that are the same with every standard library.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : random_(seed) {}
  /// In [low, high).
  double uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(random_() >> 11) * 0x1p-53);
  }
  /// Joints within the limits of an arm.
  VectorXd joints(const KinematicMap& map) {
    VectorXd q(map.joints());
    for (int i = 0; i < q.size(); ++i) q[i] = uniform(map.least[i], map.greatest[i]);
    return q;
  }

 private:
  std::mt19937_64 random_;
};

}  // namespace feder::experiments
