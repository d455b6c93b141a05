#pragma once

#include "solvers/linear/block_pivots.h"

namespace feder {

/// Doubles beyond the end of any panel or work array that the kernels may read (never use).
inline constexpr int kBlockSlack = 32;
/// Panel strides are multiples of this, so that columns are aligned for every instruction set.
inline constexpr int kPanelAlignment = 8;

/// A dense trapezoid, column-major: `columns` columns of L with `rows` rows, the first `columns` of which
/// belong to the diagonal block; rows up to `stride` are zero. The diagonal holds 1 / L_kk.
struct PanelView {
  double* at;
  int rows, columns, stride;
};

/// The loops over panels behind raw pointers, compiled once per instruction set (eight lanes measured slower
/// than four: the trapezoids are low).
struct BlockKernels {
  const char* name;
  /// target -= X Y^T: X the `rows` block rows from `source` on, Y the first `columns` of them, `depth` scalar
  /// columns deep; block row i goes to block row relative[i] of the target, block column likewise.
  void (*update)(const double* source, int stride, int depth, int rows, int columns, const int* relative,
                 double* target, int target_stride);
  /// Factors a panel in place; `original` holds its diagonal before any elimination, `first` is the scalar
  /// number of its first column. False at a bad pivot.
  bool (*eliminate)(const PanelView&, const double* original, int first, PivotWatch& watch);
  /// Substitutions on the panel's own part of x; x has one entry per row.
  void (*forward)(const PanelView&, double* x);
  void (*backward)(const PanelView&, double* x);
};

const BlockKernels& scalar_block_kernels();
const BlockKernels& avx2_block_kernels();

/// Those that fit the choice of `kernels()` in engine/kernels.h: `select_kernels("scalar")` selects these
/// too.
const BlockKernels& block_kernels();

}  // namespace feder
