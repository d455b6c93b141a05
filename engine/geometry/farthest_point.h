// One sweep over the points of a cloud, block by block so that squared distances stay in the first cache.
#pragma once

#include <algorithm>
#include <array>

#include "engine/state.h"

namespace feder {

struct Farthest {
  Eigen::Index index = 0;          ///< the first one
  double squared_distance = -1.0;  ///< [m^2]
  double sum = 0.0;                ///< of all squared distances: not finite if one of them is not
};

inline constexpr int kBlock = 512;

template <int D>
void squared_distances(const double* x, Eigen::Index d, int count, const double* centre, double* out) {
  if constexpr (D > 0) {
    std::array<double, D> c;
    std::copy(centre, centre + D, c.begin());
    for (int i = 0; i < count; ++i) {
      double sum = 0.0;
      for (int j = 0; j < D; ++j) sum += (x[D * i + j] - c[j]) * (x[D * i + j] - c[j]);
      out[i] = sum;
    }
  } else {
    const Eigen::Map<const VectorXd> c(centre, d);
    for (int i = 0; i < count; ++i) out[i] = (Eigen::Map<const VectorXd>(x + d * i, d) - c).squaredNorm();
  }
}

/// n >= 1 points of d numbers, one after the other. Every index whose squared distance is above `beyond` is
/// handed to `collect`, ascending.
template <int D, class Collect>
Farthest farthest_point(const double* x, Eigen::Index d, Eigen::Index n, const double* centre, double beyond,
                        Collect&& collect) {
  constexpr int kLanes = 4;
  Farthest out;
  std::array<double, kLanes> sums{};
  alignas(64) std::array<double, kBlock> squared;
  for (Eigen::Index first = 0; first < n; first += kBlock) {
    const int count = static_cast<int>(std::min<Eigen::Index>(kBlock, n - first));
    squared_distances<D>(x + d * first, d, count, centre, squared.data());
    std::fill(squared.begin() + count, squared.end(), 0.0);

    // lanes that do not wait for each other
    std::array<double, kLanes> largest{};
    for (int i = 0; i < kBlock; i += kLanes)
      for (int lane = 0; lane < kLanes; ++lane) {
        largest[lane] = std::max(largest[lane], squared[i + lane]);
        sums[lane] += squared[i + lane];
      }
    const double most = *std::max_element(largest.begin(), largest.end());
    if (most > out.squared_distance) {
      out.squared_distance = most;
      out.index = first + (std::find(squared.begin(), squared.end(), most) - squared.begin());
    }
    if (most > beyond)
      for (int i = 0; i < count; ++i)
        if (squared[i] > beyond) collect(first + i);
  }
  for (double sum : sums) out.sum += sum;
  return out;
}

}  // namespace feder
