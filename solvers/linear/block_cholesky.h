#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "solvers/linear/block_kernels.h"
#include "solvers/linear/block_links.h"
#include "solvers/linear/block_symbolic.h"

namespace feder {

/// Cholesky factorisation of a sparse symmetric positive definite matrix of 3 x 3 blocks, in the order it is
/// given in (fill-reducing; postordered, or panels stay narrow), one thread, the same bits in every run.
/// For problems where general codes wait on their own bookkeeping: chains, trees, nets up to some thousand
/// blocks. Block columns with one block below (links) are eliminated in one loop, the rest left-looking in
/// dense panels. A's values keep a place of their own: they survive the factorisation (residuals, second
/// factorisations) and links read them where they are, so this costs panels one copy and links nothing.
/// Two chains at a time cost little more than one: order a chain from both ends to its middle.
class BlockCholesky {
 public:
  static constexpr int kBlock = 3;

  /// `edges` are the blocks off the diagonal, either triangle, doubles welcome. Values are zero afterwards.
  void analyze(int block_columns, std::vector<std::pair<int, int>> edges);
  double flops() const { return flops_; }  ///< predicted, one factorisation
  /// Scalars of the factor, diagonal blocks counted as full, zeros added to widen panels not counted.
  std::size_t factor_entries() const { return 9 * factor_blocks_; }

  /// Place in values() of the 9 numbers of block (i, j), i >= j, column-major: entry (r, c) at slot + r + 3
  /// c. -1 if A has no such block. Analysis only: it searches. Of diagonal blocks the lower triangle is read.
  int slot(int i, int j) const;
  double* values() { return values_.data(); }
  const double* values() const { return values_.data(); }
  std::size_t value_count() const { return values_.size(); }

  /// False at a pivot that is not positive and finite (NaN included). Entries between 1e-70 and 1e70 in size.
  bool factor();
  /// Scalar column of the bad pivot, -1 if none. Of several, the first in order of work: links before panels.
  int failed_column() const { return watch_.failed_column; }
  /// Least L_kk^2 / A_kk over scalar columns: near 0 if row k nearly depends on rows before it.
  double smallest_pivot_ratio() const;
  int column_of_smallest_ratio() const { return watch_.column; }

  /// x = A^-1 x, 3 numbers per block. Needs a factorisation that succeeded. Not for two threads at a time.
  void solve(double* x) const;

 private:
  struct Panel {
    std::size_t offset;                  // in storage_
    int rows, columns, stride;           // scalars
    int first;                           // block column
    int below, below_count;              // in below_
    int update_end, copy_end, link_end;  // into the lists that follow; they start where the one before ends
  };
  struct Update {
    std::size_t source;  // in storage_: the first row that meets the target's columns
    int stride, depth, rows, columns, relative;
  };
  struct Copy {  // a block of A into the panel
    int value, target;
  };
  struct LinkUpdate {  // a link whose parent is in the panel
    int link, target;
  };

  void set_pattern(int block_columns, std::vector<std::pair<int, int>>& edges);
  void place_links(const BlockSymbolic& symbolic);
  void place_panels(const BlockSymbolic& symbolic);
  void list_updates(const BlockSymbolic& symbolic);
  LinkView links() const;
  PanelView view(const Panel& panel) const;
  void fill_panel(const Panel& panel, int copy, int link);

  double flops_ = 0.0;
  std::size_t factor_blocks_ = 0;
  std::vector<int> start_, row_;  // lower block pattern of A by columns, the diagonal first
  std::vector<double> values_;

  std::vector<int> link_column_, link_parent_, link_value_, link_child_start_, link_child_;
  std::vector<char> link_follows_;
  std::vector<LinkRun> link_run_;
  std::vector<Link> link_;

  std::vector<Panel> panel_;
  std::vector<int> below_, relative_;
  std::vector<Update> update_;
  std::vector<Copy> copy_;
  std::vector<LinkUpdate> link_update_;
  std::vector<double> storage_;
  mutable std::vector<double> work_;  // one panel's part of x; A's diagonal of one panel
  const BlockKernels* kernels_ = nullptr;
  PivotWatch watch_;
};

}  // namespace feder
