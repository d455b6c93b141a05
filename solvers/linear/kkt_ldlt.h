#pragma once

#include <string>
#include <vector>

#include "engine/kkt.h"
#include "solvers/linear/cholmod_factor.h"
#include "solvers/linear/node_blocks.h"
#include "solvers/linear/numbering.h"
#include "solvers/linear/pattern.h"

namespace feder {

/// The whole KKT matrix by CHOLMOD's simplicial LDL^T. It does not pivot, so the order carries the accuracy:
/// nodes in a fill-reducing order, each soft row directly before its first node (fill of the primal route),
/// each hard row directly after its last one, where its pivot is -(J S^-1 J^T) and not 0. Admits every
/// stiffness, c = 0 included, and Kg.
class KktLdlt {
 public:
  static constexpr const char* kName = "kkt";
  static std::string refusal(const System&, bool) { return {}; }

  Status analyze(const System& system, bool geometric);
  void assemble(const Kkt& kkt);
  Status factor(const Kkt& kkt);
  void reduce(const Kkt& kkt, const VectorXd& b1, const VectorXd& b2);
  void substitute();
  void expand(const Kkt& kkt, const VectorXd& b1, const VectorXd& b2, VectorXd& v, VectorXd& y);

  double flops() const { return factor_.flops(); }
  std::string description() const { return "simplicial LDL^T, " + ordering_ + " order"; }
  double rcond() const { return factor_.rcond(); }
  Inertia inertia() const { return inertia_; }
  const SymmetricPattern& pattern() const { return factor_.pattern(); }
  const std::vector<double>& values() const { return values_; }

 private:
  void number(std::vector<int>& node_unknown, std::vector<int>& row_unknown);

  struct Entry {  // the three places of a Jacobian block, -1 if masked
    int place[3];
  };
  const System* system_ = nullptr;
  std::string ordering_;
  bool geometric_ = false;
  std::vector<int> source_;  // of each unknown: coordinate, or -1 - row
  std::vector<Incidence> incidences_;
  std::vector<Entry> jacobian_entry_;
  std::vector<int> gamma_entry_, gamma_row_, mass_entry_, mass_coordinate_;
  CholmodFactor factor_;
  NodeBlocks blocks_;
  Inertia inertia_;
  std::vector<double> values_, rhs_;
};

}  // namespace feder
