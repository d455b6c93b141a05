#pragma once

#include <string>
#include <vector>

#include "engine/kkt.h"
#include "solvers/linear/cholmod_factor.h"
#include "solvers/linear/numbering.h"
#include "solvers/linear/pattern.h"

namespace feder {

/// Dual Schur complement S = J Mt^-1 J^T + gamma (positive definite if every row is soft or J has full row
/// rank), one unknown per active row, by CHOLMOD LL^T.
///   y = -S^-1 (b2 + J Mt^-1 b1),   v = Mt^-1 (b1 + J^T y)
/// Admits infinite stiffness; Mt must be block diagonal, so Kg is refused.
class DualSchur {
 public:
  static constexpr const char* kName = "dual";
  static std::string refusal(const System& system, bool geometric);

  Status analyze(const System& system, bool geometric);
  void assemble(const Kkt& kkt);
  Status factor(const Kkt& kkt);
  void reduce(const Kkt& kkt, const VectorXd& b1, const VectorXd& b2);
  void substitute();
  void expand(const Kkt& kkt, const VectorXd& b1, const VectorXd& b2, VectorXd& v, VectorXd& y);

  double flops() const { return factor_.flops(); }
  std::string description() const;
  /// Least pivot of the last factor, each against its diagonal entry: the squared sine between a row and
  /// those before it, in the metric of Mt^-1. 0 if the factorisation failed.
  double smallest_pivot_ratio() const { return pivot_ratio_; }
  double rcond() const { return system_->active_rows > 0 ? factor_.rcond() : 1.0; }
  Inertia inertia() const { return {system_->free_count, system_->active_rows, 0}; }
  const SymmetricPattern& pattern() const { return factor_.pattern(); }
  const std::vector<double>& values() const { return values_; }

 private:
  struct Pair {  // S[entry] += weight block_i . block_j: two distance rows at a node of equal inverse masses
    int entry, left, right, coordinate;
    double sign, weight;
  };
  struct NodeProducts {  // S[entry] += block_i . Mt^-1 block_j of all blocks at a node, i >= j; anything else
    int coordinate, blocks;
  };
  struct Diagonal {  // its own products of a distance row between such nodes: 1/m_a + 1/m_b, since |u| = 1
    int entry, row;
  };
  void keep_constants(const Kkt& kkt);

  const System* system_ = nullptr;
  std::string ordering_;
  std::vector<int> row_, unknown_;  // row of each unknown, and back
  std::vector<Diagonal> diagonal_;
  std::vector<Pair> pairs_;
  std::vector<NodeProducts> mixed_;
  std::vector<int> mixed_block_,
      mixed_entry_;             // of incidences_; -1: that product is one of pairs_ or constant
  std::vector<double> blocks_;  // those of one node, then Mt^-1 times them
  long step_serial_ = -1;       // of the Kkt whose masses and gamma constant_ and pairs_ hold
  std::vector<Incidence> incidences_;
  CholmodFactor factor_;
  std::vector<double> values_, constant_, rhs_;  // constant_: the part that only set_step changes
  VectorXd scratch_y_, pivots_;
  double pivot_ratio_ = 1.0;
};

}  // namespace feder
