#include "solvers/linear/dual_schur.h"

#include <algorithm>

namespace feder {

std::string DualSchur::refusal(const System&, bool geometric) {
  return geometric ? "dual route needs a block diagonal Mt: geometric stiffness couples nodes" : "";
}

Status DualSchur::analyze(const System& s, bool) {
  system_ = &s;
  incidences_ = incidences(s);
  row_.clear(), pairs_.clear(), mixed_.clear(), diagonal_.clear();

  // vertices are active rows, edges the pairs that meet at a node
  std::vector<int> vertex(s.rows, -1), active;
  for (int k = 0; k < s.rows; ++k)
    if (s.stiffness[k] > 0.0) {
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
  std::vector<int> unknown(s.rows, -1);
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
  for (const std::vector<int>& here : at_node)
    for (std::size_t i = 0; i < here.size(); ++i)
      for (std::size_t j = 0; j <= i; ++j) {
        const Incidence &x = incidences_[here[i]], &y = incidences_[here[j]];
        const int entry = pattern.slot(unknown[x.row], unknown[y.row]);
        const double sign = x.sign * y.sign;
        const bool simple = x.distance && y.distance && isotropic(x.node);
        if (simple && x.row != y.row)
          pairs_.push_back({entry, x.offset, y.offset, 3 * x.node, sign, 0.0});
        else if (!simple || !isotropic(s.distance.a[x.row]) || !isotropic(s.distance.b[x.row]))
          mixed_.push_back({entry, 3 * x.node, here[i], here[j], sign});
      }
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
  for (const Product& t : mixed_) {
    const double *x = incidences_[t.left].block(u, kkt.jacobian.data()),
                 *y = incidences_[t.right].block(u, kkt.jacobian.data()), *w = W + t.coordinate;
    values_[t.entry] += t.sign * (x[0] * w[0] * y[0] + x[1] * w[1] * y[1] + x[2] * w[2] * y[2]);
  }
}

Status DualSchur::factor(const Kkt&) {
  if (row_.empty()) return {};
  Status status = factor_.factor(values_.data());
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
