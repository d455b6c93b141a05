#include "solvers/linear/primal_schur.h"

#include <algorithm>
#include <cmath>

namespace feder {

std::string PrimalSchur::refusal(const System& system, bool) {
  if (!system.has_hard_rows) return {};
  for (int k = 0; k < system.rows; ++k)
    if (std::isinf(system.stiffness[k]))
      return "primal route needs finite stiffness: " + system.row_name(k) + " is rigid";
  return {};
}

Status PrimalSchur::analyze(const System& system, bool) {
  system_ = &system;
  const Numbering numbering = number_free_coordinates(system);
  ordering_ = numbering.ordering;
  coordinate_ = numbering.coordinate;

  std::vector<std::pair<int, int>> entries;
  for (const auto& [i, j] : coupled_nodes(system))
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c)
        if (numbering.unknown[3 * i + r] >= 0 && numbering.unknown[3 * j + c] >= 0)
          entries.emplace_back(numbering.unknown[3 * i + r], numbering.unknown[3 * j + c]);
  for (std::size_t k = 0; k < coordinate_.size(); ++k)  // coordinates of one node are consecutive
    for (std::size_t l = k + 1; l < coordinate_.size() && coordinate_[l] / 3 == coordinate_[k] / 3; ++l)
      entries.emplace_back(static_cast<int>(l), static_cast<int>(k));

  if (Status status =
          factor_.analyze(make_pattern(system.free_count, std::move(entries)), CholmodFactor::Kind::kLlt);
      !status.ok())
    return status;
  blocks_.analyze(system, numbering.unknown, factor_.pattern());
  values_.assign(factor_.pattern().entries(), 0.0);
  rhs_.assign(coordinate_.size(), 0.0);
  scratch_v_ = VectorXd::Zero(3 * system.nodes);
  scratch_y_ = VectorXd::Zero(system.rows);
  return {};
}

void PrimalSchur::assemble(const Kkt& kkt) {
  std::fill(values_.begin(), values_.end(), 0.0);
  blocks_.add(kkt, true, values_);
}

Status PrimalSchur::factor(const Kkt&) {
  Status status = factor_.factor(values_.data());
  if (status.code == StatusCode::kSingular && factor_.failed_column() >= 0) {
    const int coordinate =
        coordinate_[std::min<std::size_t>(factor_.failed_column(), coordinate_.size() - 1)];
    status.reason =
        "primal Schur complement is not positive definite at node " + std::to_string(coordinate / 3);
  }
  return status;
}

void PrimalSchur::reduce(const Kkt& kkt, const VectorXd& b1, const VectorXd& b2) {
  // S v = b1 - J^T gamma^-1 b2
  scratch_y_.array() = -kkt.inverse_gamma.array() * b2.array();
  scratch_v_ = b1;
  kkt.add_jacobian_transpose(scratch_y_, scratch_v_);
  for (std::size_t i = 0; i < coordinate_.size(); ++i) rhs_[i] = scratch_v_[coordinate_[i]];
}

void PrimalSchur::substitute() {
  factor_.solve(rhs_.data(), rhs_.data());
}

void PrimalSchur::expand(const Kkt& kkt, const VectorXd&, const VectorXd& b2, VectorXd& v, VectorXd& y) {
  v.setZero(3 * system_->nodes);
  for (std::size_t i = 0; i < coordinate_.size(); ++i) v[coordinate_[i]] = rhs_[i];
  // y = -gamma^-1 (J v + b2)
  kkt.multiply_jacobian(v, y);
  y.array() = -kkt.inverse_gamma.array() * (y.array() + b2.array());
}

std::string PrimalSchur::description() const {
  return std::string(factor_.supernodal() ? "supernodal" : "simplicial") + " LL^T, " + ordering_ + " order";
}

}  // namespace feder
