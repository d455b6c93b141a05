#include "solvers/linear/dual_schur.h"

#include <algorithm>

namespace feder {

std::string DualSchur::refusal(const System&, bool geometric) {
  return geometric ? "dual route needs a block diagonal Mt: geometric stiffness couples nodes" : "";
}

Status DualSchur::analyze(const System& s, bool) {
  system_ = &s;
  incidences_ = incidences(s);
  row_.clear(), pairs_.clear(), mixed_.clear(), mixed_block_.clear(), mixed_entry_.clear(), diagonal_.clear();

  // vertices are active rows, edges the pairs that meet at a node
  std::vector<int> vertex(s.rows, -1), active;
  for (int k = 0; k < s.rows; ++k)
    if (s.active(k)) {
      vertex[k] = static_cast<int>(active.size());
      active.push_back(k);
    }
  std::vector<std::vector<int>> at_node(s.nodes);
  for (std::size_t i = 0; i < incidences_.size(); ++i)
    at_node[incidences_[i].node].push_back(static_cast<int>(i));
  std::vector<std::pair<int, int>> edges;
  for (const std::vector<int>& here : at_node)
    for (std::size_t i = 0; i < here.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (incidences_[here[i]].row != incidences_[here[j]].row)
          edges.emplace_back(vertex[incidences_[here[i]].row], vertex[incidences_[here[j]].row]);
  const Ordering ordering = fill_reducing_order(static_cast<int>(active.size()), edges, 1);
  ordering_ = ordering.name;
  unknown_.assign(s.rows, -1);
  std::vector<int>& unknown = unknown_;
  for (int v : ordering.order) {
    unknown[active[v]] = static_cast<int>(row_.size());
    row_.push_back(active[v]);
  }
  for (auto& [i, j] : edges) i = unknown[active[i]], j = unknown[active[j]];
  if (Status status = factor_.analyze(make_pattern(static_cast<int>(row_.size()), std::move(edges)),
                                      CholmodFactor::Kind::kLlt);
      !status.ok())
    return status;

  // every product of two blocks at a node has its place
  const SymmetricPattern& pattern = factor_.pattern();
  auto isotropic = [&](int node) { return s.free[node] == kFree || s.free[node] == kPinned; };
  std::size_t most = 0;
  for (const std::vector<int>& here : at_node) {
    std::vector<int> entries;
    bool any = false;
    for (std::size_t i = 0; i < here.size(); ++i)
      for (std::size_t j = 0; j <= i; ++j) {
        const Incidence &x = incidences_[here[i]], &y = incidences_[here[j]];
        const int entry = pattern.slot(unknown[x.row], unknown[y.row]);
        const bool simple = x.distance && y.distance && isotropic(x.node);
        const bool own =
            simple && x.row == y.row && isotropic(s.distance.a[x.row]) && isotropic(s.distance.b[x.row]);
        if (simple && x.row != y.row)
          pairs_.push_back({entry, x.offset, y.offset, 3 * x.node, x.sign * y.sign, 0.0});
        entries.push_back(simple && (own || x.row != y.row) ? -1 : entry);
        any = any || entries.back() >= 0;
      }
    if (!any) continue;
    mixed_.push_back({3 * incidences_[here[0]].node, static_cast<int>(here.size())});
    mixed_block_.insert(mixed_block_.end(), here.begin(), here.end());
    mixed_entry_.insert(mixed_entry_.end(), entries.begin(), entries.end());
    most = std::max(most, here.size());
  }
  blocks_.assign(6 * most, 0.0);
  std::sort(pairs_.begin(), pairs_.end(), [](const Pair& x, const Pair& y) { return x.entry < y.entry; });
  for (int i = 0; i < pattern.size; ++i) diagonal_.push_back({pattern.slot(i, i), row_[i]});
  step_serial_ = -1;
  values_.assign(pattern.entries(), 0.0);
  constant_ = values_;
  rhs_.assign(row_.size(), 0.0);
  scratch_y_ = VectorXd::Zero(s.rows);
  return {};
}

// gamma, and what masses alone decide: changes with the step size only.
void DualSchur::keep_constants(const Kkt& kkt) {
  const System& s = *system_;
  auto isotropic = [&](int node) { return s.free[node] == kFree || s.free[node] == kPinned; };
  step_serial_ = kkt.step_serial();
  for (Pair& t : pairs_) t.weight = t.sign * kkt.inverse_mass[t.coordinate];
  for (Diagonal& d : diagonal_) {
    double& value = constant_[d.entry];
    value = kkt.gamma[d.row];
    if (d.row >= s.distance.size()) continue;
    const int a = s.distance.a[d.row], b = s.distance.b[d.row];
    // a row that cannot push has J = 0
    if (isotropic(a) && isotropic(b) && (kkt.inverse_gamma[d.row] > 0.0 || kkt.gamma[d.row] == 0.0))
      value += kkt.inverse_mass[3 * a] + kkt.inverse_mass[3 * b];
  }
}

void DualSchur::assemble(const Kkt& kkt) {
  const double *u = kkt.u.data(), *W = kkt.inverse_mass.data();
  if (kkt.step_serial() != step_serial_) keep_constants(kkt);
  values_ = constant_;
  for (const Pair& t : pairs_) {
    const double *x = u + t.left, *y = u + t.right;
    values_[t.entry] += t.weight * (x[0] * y[0] + x[1] * y[1] + x[2] * y[2]);
  }
  const int *block = mixed_block_.data(), *entry = mixed_entry_.data();
  for (const NodeProducts& node : mixed_) {
    double *x = blocks_.data(), *Wx = x + 3 * node.blocks;
    for (int i = 0; i < node.blocks; ++i) {
      const Incidence& incidence = incidences_[*block++];
      const double* from = incidence.block(u, kkt.jacobian.data());
      for (int c = 0; c < 3; ++c) {
        x[3 * i + c] = incidence.sign * from[c];
        Wx[3 * i + c] = W[node.coordinate + c] * x[3 * i + c];
      }
    }
    for (int i = 0; i < node.blocks; ++i)
      for (int j = 0; j <= i; ++j, ++entry)
        if (*entry >= 0)
          values_[*entry] +=
              Wx[3 * i] * x[3 * j] + Wx[3 * i + 1] * x[3 * j + 1] + Wx[3 * i + 2] * x[3 * j + 2];
  }
}

Status DualSchur::factor(const Kkt&) {
  pivot_ratio_ = 1.0;
  if (row_.empty()) return {};
  Status status = factor_.factor(values_.data());
  if (!status.ok())
    pivot_ratio_ = 0.0;
  else if (system_->has_hard_rows) {
    factor_.read_pivots(pivots_);
    for (const Diagonal& d : diagonal_)
      pivot_ratio_ = std::min(pivot_ratio_, pivots_[unknown_[d.row]] / values_[d.entry]);
  }
  if (status.code == StatusCode::kSingular && factor_.failed_column() >= 0)
    status.reason = "dual Schur complement is not positive definite at " +
                    system_->row_name(row_[std::min<std::size_t>(factor_.failed_column(), row_.size() - 1)]);
  return status;
}

void DualSchur::reduce(const Kkt& kkt, const VectorXd& b1, const VectorXd& b2) {
  // S y = -(b2 + J Mt^-1 b1)
  kkt.multiply_jacobian_inverse_mass(b1, scratch_y_);
  for (std::size_t i = 0; i < row_.size(); ++i) rhs_[i] = -(scratch_y_[row_[i]] + b2[row_[i]]);
}

void DualSchur::substitute() {
  if (!row_.empty()) factor_.solve(rhs_.data(), rhs_.data());
}

void DualSchur::expand(const Kkt& kkt, const VectorXd& b1, const VectorXd&, VectorXd& v, VectorXd& y) {
  y.setZero(system_->rows);
  for (std::size_t i = 0; i < row_.size(); ++i) y[row_[i]] = rhs_[i];
  // v = Mt^-1 (b1 + J^T y)
  v = b1;
  kkt.add_jacobian_transpose(y, v);
  kernels().product(v.size(), v.data(), kkt.inverse_mass.data(), v.data());
}

std::string DualSchur::description() const {
  return std::string(!row_.empty() && factor_.supernodal() ? "supernodal" : "simplicial") + " LL^T, " +
         ordering_ + " order";
}

}  // namespace feder
