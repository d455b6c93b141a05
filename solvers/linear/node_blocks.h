#pragma once

#include <vector>

#include "engine/kkt.h"
#include "solvers/linear/pattern.h"

namespace feder {

/// Scatters node-pair blocks into the values of a sparse matrix: the mass diagonal, sigma Kg, and (primal
/// route) J^T gamma^-1 J. All places are found once; a fill neither searches nor allocates.
class NodeBlocks {
 public:
  /// unknown[3 node + c] is the matrix index of a coordinate, -1 if masked; free coordinates of a node are
  /// consecutive.
  void analyze(const System& system, const std::vector<int>& unknown, const SymmetricPattern& pattern);
  /// values += Mt, and + J^T gamma^-1 J if `with_rows`.
  void add(const Kkt& kkt, bool with_rows, std::vector<double>& values);

 private:
  struct WholeRow {  // distance row between two nodes with three free coordinates each
    int row, a, b;
    int column[3];  // where the three columns of its block begin
  };
  struct PartRow {  // any other distance row: each entry on its own
    int row, a, b;
    int entry[9];
  };
  void add_stencils(const Kkt& kkt, bool with_rows, std::vector<double>& values);

  const System* system_ = nullptr;
  std::vector<WholeRow> whole_;
  std::vector<PartRow> part_;
  std::vector<int> diagonal_entry_;  // 6 per node: xx xy xz yy yz zz
  std::vector<int> stencil_entry_;   // (3k)^2 per stencil, lower blocks only, -1 elsewhere
  std::vector<double> diagonal_;     // 6 per node, summed here first
  std::vector<double> stencil_scratch_;
};

}  // namespace feder
