// rho_i = sum_j m_j W(|x_i - x_j|) (notes G1), and the gradient of every pair, (dW/dr)/r (x_i - x_j).
#include "engine/fluid/fluid_pairs.h"

#include <cmath>

namespace feder {

// Appends those of begin to end - 1 that are near i; returns the new count. Without branches: most are not.
template <int D>
int FluidPairs::near(int i, int begin, int end, double support_squared, int count) {
  const double *a = x[0].data(), *b = x[1].data(), *c = x[2].data();
  double* squared = squared_.data();
  for (int j = begin; j < end; ++j) {
    double r2 = (a[i] - a[j]) * (a[i] - a[j]);
    if constexpr (D > 1) r2 += (b[i] - b[j]) * (b[i] - b[j]);
    if constexpr (D > 2) r2 += (c[i] - c[j]) * (c[i] - c[j]);
    squared[j - begin] = r2;
  }
  int* to = neighbour.data();
  double* kept = slope.data();
  if (sample_[i] == 0) {
    for (int j = begin; j < end; ++j) {
      to[count] = j;
      kept[count] = squared[j - begin];
      count += squared[j - begin] < support_squared;
    }
  } else {
    for (int j = begin; j < end; ++j) {
      to[count] = j;
      kept[count] = squared[j - begin];
      count += static_cast<int>(squared[j - begin] < support_squared) & ~sample_[j];
    }
  }
  return count;
}

template <SmoothingKernel K, int D>
void FluidPairs::collect(double support) {
  using Shape = KernelShape<K, D>;
  const double norm = Shape::norm() / std::pow(support, D), slope_norm = norm / support;
  const double per_support = 1.0 / support, own = norm * Shape::value(0.0);
  for (std::size_t i = 0; i < mass.size(); ++i) density[i] += sample_[i] ? 0.0 : mass[i] * own;
  int count = 0;
  grid_.for_each_cell(
      [&](NeighbourGrid::Range cell, int row_end, const NeighbourGrid::Range* ahead, int rows) {
        std::size_t most = static_cast<std::size_t>(row_end - cell.first);
        for (int row = 0; row < rows; ++row)
          most += static_cast<std::size_t>(ahead[row].last - ahead[row].first);
        if (squared_.size() < most) squared_.resize(most);
        for (int i = cell.first; i < cell.last; ++i) {
          const int begin = count;
          if (neighbour.size() < count + most) {
            neighbour.resize(2 * (count + most));
            slope.resize(neighbour.size());
          }
          count = near<D>(i, i + 1, row_end, support * support, count);
          for (int row = 0; row < rows; ++row)
            count = near<D>(i, ahead[row].first, ahead[row].last, support * support, count);
          // densities and gradients of the pairs found
          double sum = 0.0;
          for (int k = begin; k < count; ++k) {
            const int j = neighbour[k];
            const double r = std::sqrt(slope[k]), s = r * per_support;
            const double W = norm * Shape::value(s);
            sum += mass[j] * W;
            density[j] += mass[i] * W;
            slope[k] = r > 0.0 ? slope_norm * Shape::slope(s) / r : 0.0;
          }
          density[i] += sum;
          first[i + 1] = count;
        }
      });
}

void FluidPairs::find(SmoothingKernel kernel, int dimensions, double support, int fluid_points,
                      const std::vector<double>& at, const std::vector<double>& weight,
                      const std::vector<double>& sample_density) {
  dimension = dimensions;
  fluid = fluid_points;
  const std::size_t points = weight.size();
  grid_.sort(at.data(), static_cast<int>(points), dimension, support);
  for (int c = 0; c < 3; ++c) x[c].resize(c < dimension ? points : 0);
  mass.resize(points);
  density.assign(points, 0.0);
  sample_.resize(points);
  first.assign(points + 1, 0);
  for (std::size_t i = 0; i < points; ++i) {
    const std::size_t from = static_cast<std::size_t>(grid_.order()[i]);
    for (int c = 0; c < dimension; ++c) x[c][i] = at[dimension * from + c];
    mass[i] = weight[from];
    sample_[i] = from >= static_cast<std::size_t>(fluid);
    if (sample_[i] && !sample_density.empty()) density[i] = sample_density[from - fluid];
  }
  with_kernel(kernel, dimension, [&]<SmoothingKernel K, int D>() { collect<K, D>(support); });
}

}  // namespace feder
