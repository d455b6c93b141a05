#pragma once

#include <vector>

#include "engine/fluid/neighbour_grid.h"
#include "engine/fluid/smoothing_kernel.h"

namespace feder {

/// Smoothed particles sorted by cell, and every pair of them closer than the support, once. Places are
/// positions in that order; point(place) is whose it is. The first `fluid` points are fluid, the others
/// boundary samples: two of those make no pair.
struct FluidPairs {
  int dimension = 3, fluid = 0;
  std::vector<double> x[3];     ///< by place [m]
  std::vector<double> mass;     ///< [kg], of samples rest density times volume
  std::vector<double> density;  ///< sum_j m_j W, itself included [kg/m^D]; of samples what the fluid gives
  std::vector<int> first;       ///< pairs of place i: first[i] to first[i + 1] - 1
  std::vector<int> neighbour;   ///< the other place, > i
  std::vector<double> slope;    ///< (dW/dr)/r, 0 where points coincide [1/m^(D+2)]

  /// at: D numbers per point [m], finite; weight: mass per point; sample_density: what
  /// the density of each sample starts with, 0 if empty. Linear in the number of pairs.
  void find(SmoothingKernel kernel, int dimension, double support, int fluid, const std::vector<double>& at,
            const std::vector<double>& weight, const std::vector<double>& sample_density = {});
  int size() const { return static_cast<int>(mass.size()); }
  int point(int place) const { return grid_.order()[place]; }
  bool is_fluid(int place) const { return point(place) < fluid; }

 private:
  template <SmoothingKernel K, int D>
  void collect(double support);
  template <int D>
  int near(int i, int begin, int end, double support_squared, int count);

  NeighbourGrid grid_;
  std::vector<int> sample_;      // 1 for boundary samples
  std::vector<double> squared_;  // distances of one row ahead [m^2]
};

}  // namespace feder
