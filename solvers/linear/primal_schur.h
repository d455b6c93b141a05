#pragma once

#include <string>
#include <vector>

#include "engine/kkt.h"
#include "solvers/linear/cholmod_factor.h"
#include "solvers/linear/node_blocks.h"
#include "solvers/linear/numbering.h"

namespace feder {

/// Primal Schur complement S = Mt + J^T gamma^-1 J (positive definite), n unknowns, by CHOLMOD LL^T.
///   v = S^-1 (b1 - J^T gamma^-1 b2),   y = -gamma^-1 (J v + b2)
/// Admits every finite stiffness and Kg; no hard rows (gamma = 0 has no inverse).
class PrimalSchur {
 public:
  static constexpr const char* kName = "primal";
  /// Empty if the route can take the scene, otherwise the reason.
  static std::string refusal(const System& system, bool geometric);

  Status analyze(const System& system, bool geometric);
  void assemble(const Kkt& kkt);
  Status factor(const Kkt& kkt);
  void reduce(const Kkt& kkt, const VectorXd& b1, const VectorXd& b2);
  void substitute();
  void expand(const Kkt& kkt, const VectorXd& b1, const VectorXd& b2, VectorXd& v, VectorXd& y);

  double flops() const { return factor_.flops(); }
  std::string description() const;
  double rcond() const { return factor_.rcond(); }
  /// S positive definite and gamma > 0 give (n, m, 0) by Haynsworth's formula.
  Inertia inertia() const { return {system_->free_count, system_->active_rows, 0}; }
  /// The assembled matrix, for benchmarks that factor it bare.
  const SymmetricPattern& pattern() const { return factor_.pattern(); }
  const std::vector<double>& values() const { return values_; }

 private:
  const System* system_ = nullptr;
  std::string ordering_;
  std::vector<int> coordinate_;  // of each unknown
  CholmodFactor factor_;
  NodeBlocks blocks_;
  std::vector<double> values_, rhs_;
  VectorXd scratch_v_, scratch_y_;
};

}  // namespace feder
