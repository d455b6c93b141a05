// Cell of a point: i_c = floor((x_c - origin_c)/edge_c), key = (i_z n_y + i_y) n_x + i_x with free cells on
// either side of every axis, so that neighbours along x are key - 4 to key + 4. Keys are sorted by counting,
// eleven bits at a time; rows of nine cells ahead are then met by pointers that only move forward.
#include "engine/fluid/neighbour_grid.h"

#include <algorithm>
#include <cmath>

#include "engine/check.h"

namespace feder {
namespace {

constexpr double kMostCells = 1 << 20;  // along an axis: three axes fit a key
// An edge above the support: rounding of (x - origin)/edge, 2^20 cells at most, takes no pair two cells
// apart.
constexpr double kEdge = 1.0 + 1e-8;

}  // namespace

void NeighbourGrid::number_cells(const double* x, int points, int dimension, double support) {
  Key stride[4] = {1, 0, 0, 0};
  keys_.assign(points, 0);
  for (int c = 0; c < dimension; ++c) {
    const int reach = c == 0 ? kReach : 1;  // cells that the support reaches
    const double edge = kEdge * support / reach;
    double low = x[c], high = x[c];
    for (int i = 1; i < points; ++i) {
      low = std::min(low, x[dimension * i + c]);
      high = std::max(high, x[dimension * i + c]);
    }
    if (!((high - low) / edge < kMostCells - 4.0)) {  // merge what is far from the middle
      column_.resize(points);
      for (int i = 0; i < points; ++i) column_[i] = x[dimension * i + c];
      std::nth_element(column_.begin(), column_.begin() + points / 2, column_.end());
      low = column_[points / 2] - 0.5 * (kMostCells - 4.0) * edge;
      high = low + (kMostCells - 4.0) * edge;
    }
    const double last = std::floor((high - low) / edge);
    for (int i = 0; i < points; ++i) {
      const double cell = std::clamp(std::floor((x[dimension * i + c] - low) / edge), 0.0, last);
      keys_[i] += stride[c] * (static_cast<Key>(cell) + reach);
    }
    stride[c + 1] = stride[c] * (static_cast<Key>(last) + 1 + 2 * reach);
  }
  // rows ahead: (dy, dz) = (1, 0), (-1, 1), (0, 1), (1, 1)
  rows_ = 0;
  if (dimension > 1) row_step_[rows_++] = stride[1];
  if (dimension > 2)
    for (const Key step : {stride[2] - stride[1], stride[2], stride[2] + stride[1]})
      row_step_[rows_++] = step;
  int bits = 0;
  while (bits < 63 && (stride[dimension] >> bits) > 0) ++bits;
  sort_keys(bits);
}

void NeighbourGrid::sort_keys(int bits) {
  constexpr int kDigit = 11;
  const std::size_t points = keys_.size();
  order_.resize(points);
  order_next_.resize(points);
  keys_next_.resize(points);
  for (std::size_t i = 0; i < points; ++i) order_[i] = static_cast<int>(i);
  for (int shift = 0; shift < bits; shift += kDigit) {
    std::uint32_t start[(1 << kDigit) + 1] = {};
    for (const Key key : keys_) ++start[(key >> shift & ((1 << kDigit) - 1)) + 1];
    for (int d = 0; d < 1 << kDigit; ++d) start[d + 1] += start[d];
    for (std::size_t i = 0; i < points; ++i) {
      const std::uint32_t to = start[keys_[i] >> shift & ((1 << kDigit) - 1)]++;
      keys_next_[to] = keys_[i];
      order_next_[to] = order_[i];
    }
    keys_.swap(keys_next_);
    order_.swap(order_next_);
  }
}

void NeighbourGrid::sort(const double* x, int points, int dimension, double support) {
  FEDER_CHECK(dimension >= 1 && dimension <= 3 && support > 0.0,
              "neighbour grid: 1 to 3 dimensions, support > 0");
  cell_keys_.clear();
  cell_first_.clear();
  order_.clear();
  if (points > 0) number_cells(x, points, dimension, support);
  for (int i = 0; i < points; ++i)
    if (i == 0 || keys_[i] != keys_[i - 1]) {
      cell_keys_.push_back(keys_[i]);
      cell_first_.push_back(i);
    }
  cell_first_.push_back(points);
}

}  // namespace feder
