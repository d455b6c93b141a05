#include "solvers/linear/kkt_ldlt.h"

#include <algorithm>
#include <cmath>

namespace feder {

// Walks the nodes in elimination order; rows are placed around them as the class comment says.
void KktLdlt::number(std::vector<int>& unknown, std::vector<int>& row_unknown) {
  const System& s = *system_;
  const Numbering numbering = number_free_coordinates(s);
  ordering_ = numbering.ordering;
  std::vector<int> rank(s.nodes, -1), nodes;
  for (int coordinate : numbering.coordinate)
    if (rank[coordinate / 3] < 0) {
      rank[coordinate / 3] = static_cast<int>(nodes.size());
      nodes.push_back(coordinate / 3);
    }
  std::vector<int> first(s.rows, s.nodes), last(s.rows, -1);
  for (const Incidence& i : incidences_) {
    first[i.row] = std::min(first[i.row], rank[i.node]);
    last[i.row] = std::max(last[i.row], rank[i.node]);
  }
  std::vector<std::vector<int>> before(nodes.size() + 1), after(nodes.size() + 1);
  for (int k = 0; k < s.rows; ++k) {
    if (!s.active(k)) continue;
    const bool hard = std::isinf(s.stiffness[k]);
    if (last[k] < 0)  // between world points: decoupled
      before[nodes.size()].push_back(k);
    else
      (hard ? after[last[k]] : before[first[k]]).push_back(k);
  }
  unknown.assign(3 * s.nodes, -1);
  row_unknown.assign(s.rows, -1);
  auto place_rows = [&](const std::vector<int>& rows) {
    for (int k : rows) {
      row_unknown[k] = static_cast<int>(source_.size());
      source_.push_back(-1 - k);
    }
  };
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    place_rows(before[i]);
    for (int c = 0; c < 3; ++c)
      if (s.free[nodes[i]] >> c & 1) {
        unknown[3 * nodes[i] + c] = static_cast<int>(source_.size());
        source_.push_back(3 * nodes[i] + c);
      }
    place_rows(after[i]);
  }
  place_rows(before[nodes.size()]);
}

Status KktLdlt::analyze(const System& s, bool geometric) {
  *this = {};
  system_ = &s;
  geometric_ = geometric;
  incidences_ = incidences(s);
  std::vector<int> unknown, row_unknown;
  number(unknown, row_unknown);

  std::vector<std::pair<int, int>> entries;
  for (const Incidence& i : incidences_)
    for (int c = 0; c < 3; ++c)
      if (unknown[3 * i.node + c] >= 0) entries.emplace_back(row_unknown[i.row], unknown[3 * i.node + c]);
  if (geometric) {
    for (const auto& [i, j] : coupled_nodes(s))
      for (int e = 0; e < 9; ++e)
        if (unknown[3 * i + e / 3] >= 0 && unknown[3 * j + e % 3] >= 0)
          entries.emplace_back(unknown[3 * i + e / 3], unknown[3 * j + e % 3]);
    for (int i = 0; i < s.nodes; ++i)
      for (int e = 0; e < 9; ++e)
        if (unknown[3 * i + e / 3] >= 0 && unknown[3 * i + e % 3] >= 0)
          entries.emplace_back(unknown[3 * i + e / 3], unknown[3 * i + e % 3]);
  }
  const int size = static_cast<int>(source_.size());
  if (Status status = factor_.analyze(make_pattern(size, std::move(entries)), CholmodFactor::Kind::kLdlt);
      !status.ok())
    return status;

  const SymmetricPattern& pattern = factor_.pattern();
  for (const Incidence& i : incidences_) {
    Entry entry{};
    for (int c = 0; c < 3; ++c) entry.place[c] = pattern.slot(row_unknown[i.row], unknown[3 * i.node + c]);
    jacobian_entry_.push_back(entry);
  }
  for (int i = 0; i < size; ++i) {
    const bool is_row = source_[i] < 0;
    (is_row ? gamma_entry_ : mass_entry_).push_back(pattern.slot(i, i));
    (is_row ? gamma_row_ : mass_coordinate_).push_back(is_row ? -1 - source_[i] : source_[i]);
  }
  if (geometric) blocks_.analyze(s, unknown, pattern);
  values_.assign(pattern.entries(), 0.0);
  rhs_.assign(size, 0.0);
  return {};
}

void KktLdlt::assemble(const Kkt& kkt) {
  std::fill(values_.begin(), values_.end(), 0.0);
  if (geometric_)
    blocks_.add(kkt, false, values_);
  else
    for (std::size_t i = 0; i < mass_entry_.size(); ++i)
      values_[mass_entry_[i]] = kkt.mass[mass_coordinate_[i]];
  for (std::size_t i = 0; i < gamma_entry_.size(); ++i) values_[gamma_entry_[i]] = -kkt.gamma[gamma_row_[i]];
  for (std::size_t i = 0; i < incidences_.size(); ++i) {
    const double* block = incidences_[i].block(kkt.u.data(), kkt.jacobian.data());
    for (int c = 0; c < 3; ++c)
      if (jacobian_entry_[i].place[c] >= 0)
        values_[jacobian_entry_[i].place[c]] = -incidences_[i].sign * block[c];
  }
}

Status KktLdlt::factor(const Kkt&) {
  Status status = factor_.factor(values_.data());
  if (status.code == StatusCode::kSingular && factor_.failed_column() >= 0) {
    const int source = source_[std::min<std::size_t>(factor_.failed_column(), source_.size() - 1)];
    status.reason = "KKT matrix has a zero pivot at " +
                    (source < 0 ? system_->row_name(-1 - source) : "node " + std::to_string(source / 3));
  }
  if (!status.ok()) return status;
  const CholmodFactor::Signs signs = factor_.pivot_signs();
  inertia_ = {signs.positive, signs.negative, signs.other};
  return {};
}

void KktLdlt::reduce(const Kkt&, const VectorXd& b1, const VectorXd& b2) {
  for (std::size_t i = 0; i < source_.size(); ++i)
    rhs_[i] = source_[i] < 0 ? b2[-1 - source_[i]] : b1[source_[i]];
}

void KktLdlt::substitute() {
  factor_.solve(rhs_.data(), rhs_.data());
}

void KktLdlt::expand(const Kkt&, const VectorXd&, const VectorXd&, VectorXd& v, VectorXd& y) {
  v.setZero(3 * system_->nodes);
  y.setZero(system_->rows);
  for (std::size_t i = 0; i < source_.size(); ++i)
    (source_[i] < 0 ? y[-1 - source_[i]] : v[source_[i]]) = rhs_[i];
}

}  // namespace feder
