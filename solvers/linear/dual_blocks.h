#pragma once

#include <string>
#include <vector>

#include "engine/kkt.h"
#include "solvers/linear/block_cholesky.h"
#include "solvers/linear/numbering.h"

namespace feder {

/// The dual Schur complement of design.md section 1 where every row belongs to a ball joint: S = J Mt^-1 J^T
/// + gamma in 3 x 3 blocks, one per joint, by block Cholesky instead of CHOLMOD (see DualSchur for the
/// formulas).
class DualBlocks {
 public:
  static constexpr const char* kName = "dual_blocks";
  static std::string refusal(const System& system, bool geometric);

  Status analyze(const System& system, bool geometric);
  void assemble(const Kkt& kkt);
  Status factor(const Kkt& kkt);
  void reduce(const Kkt& kkt, const VectorXd& b1, const VectorXd& b2);
  void substitute();
  void expand(const Kkt& kkt, const VectorXd& b1, const VectorXd& b2, VectorXd& v, VectorXd& y);

  double flops() const { return factor_.flops(); }
  std::string description() const { return "block LL^T, " + ordering_ + " order"; }
  double smallest_pivot_ratio() const { return factor_.smallest_pivot_ratio(); }
  double rcond() const { return smallest_pivot_ratio(); }  ///< the least pivot against its diagonal entry
  Inertia inertia() const { return {system_->free_count, system_->active_rows, 0}; }

 private:
  struct Product {  // values[place] += J_i Mt^-1 J_j^T at one node
    int place, left, left_stride, right, right_stride, coordinate;
  };
  std::vector<int> order_joints(const std::vector<std::pair<int, int>>& edges, int joints);

  const System* system_ = nullptr;
  std::string ordering_;
  std::vector<int> first_row_, diagonal_;  // of each block: its joint's first row, its place
  std::vector<Product> products_;
  BlockCholesky factor_;
  std::vector<double> rhs_;
  VectorXd scratch_y_;
};

}  // namespace feder
