#pragma once

#include <cstdint>
#include <vector>

namespace feder {

/// Which of many points in D = 1 to 3 dimensions lie within `support` of each other: points sorted by cells
/// of that size, a quarter of it along x; only cells that hold points are stored. Linear in time and memory
/// however far the points scatter (cells further than a million from the middle are merged, which costs time
/// only). Buffers are reused; order and pairs depend on the points alone.
class NeighbourGrid {
 public:
  /// x: D numbers per point [m], finite; support [m] > 0.
  void sort(const double* x, int points, int dimension, double support);
  /// Points by cell; within a cell as given.
  const std::vector<int>& order() const { return order_; }

  /// Places [first, last) in order().
  struct Range {
    int first, last;
  };
  /// Calls visit(cell, row_end, ahead, count) for every cell: places that may be near a point at place i of
  /// `cell` are i + 1 to row_end and the `count` ranges `ahead`. So every pair of places is met once.
  template <class Visit>
  void for_each_cell(Visit&& visit) const;

 private:
  using Key = std::uint64_t;
  static constexpr int kMostRows = 4;
  static constexpr int kReach = 4;  // cells along x that the support reaches

  void number_cells(const double* x, int points, int dimension, double support);
  void sort_keys(int bits);

  std::vector<Key> keys_, keys_next_;
  std::vector<int> order_, order_next_;
  std::vector<double> column_;
  std::vector<Key> cell_keys_;
  std::vector<int> cell_first_;
  Key row_step_[kMostRows] = {};  // key of the cell in the middle of each row ahead, less the own
  int rows_ = 0;
};

template <class Visit>
void NeighbourGrid::for_each_cell(Visit&& visit) const {
  const int cells = static_cast<int>(cell_keys_.size());
  int from[kMostRows] = {}, to[kMostRows] = {}, own = 0;  // cells: all only move forward
  Range ahead[kMostRows];
  for (int c = 0; c < cells; ++c) {
    const Key key = cell_keys_[c];
    while (own < cells && cell_keys_[own] <= key + kReach) ++own;
    int count = 0;
    for (int row = 0; row < rows_; ++row) {
      const Key middle = key + row_step_[row];
      while (from[row] < cells && cell_keys_[from[row]] + kReach < middle) ++from[row];
      while (to[row] < cells && cell_keys_[to[row]] <= middle + kReach) ++to[row];
      if (from[row] < to[row]) ahead[count++] = {cell_first_[from[row]], cell_first_[to[row]]};
    }
    visit(Range{cell_first_[c], cell_first_[c + 1]}, cell_first_[own], ahead, count);
  }
}

}  // namespace feder
