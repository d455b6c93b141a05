#pragma once

#include <vector>

namespace feder {

/// Consecutive block columns factored as one dense trapezoid: all of them hold the rows `below`.
struct BlockPanel {
  int first = 0, columns = 0;
  std::vector<int> below;

  int block_rows() const { return columns + static_cast<int>(below.size()); }
};

/// What the pattern of a block Cholesky factor looks like. A link is a block column with at most one block
/// below its diagonal, as all its descendants: chains and trees are made of links. Panels are the rest.
struct BlockSymbolic {
  std::vector<int> parent;  ///< of each block column in the elimination tree; -1: a root
  std::vector<int> links;   ///< ascending
  std::vector<BlockPanel> panels;
  double flops = 0.0;             ///< scalar multiplications and additions, zeros that panels add not counted
  std::size_t factor_blocks = 0;  ///< without those zeros
};

/// `start` and `row` are the lower block pattern by columns: rows ascending, the diagonal first.
BlockSymbolic block_symbolic(const std::vector<int>& start, const std::vector<int>& row);

}  // namespace feder
