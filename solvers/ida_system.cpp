// The equations of motion as F(t, y, y') = 0 (see the header) and their Jacobian dF/dy + cj dF/dy'. With
// lambda(q, v) = -d (phi + tau J v) the derivatives per row are
//   d(J^T lambda)/dq = lambda Hess + J^T dlambda/dq,   dlambda/dq = -d (J + tau d(J v)/dq),   d(J v)/dq =
//   (Hess v)^T, dlambda/dv = -d tau J;   -sum lambda Hess = Kg comes from Kkt, full and at sigma = 1.
// The pattern is found once by recording where every term goes; later fills walk through the terms in the
// same order.
#include "solvers/ida_system.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "engine/check.h"

namespace feder {

IdaSystem::IdaSystem(const System& s, const State& state, IdaForm form)
    : system_(s), form_(form), state_(state) {
  FEDER_CHECK(form != IdaForm::kAutomatic, "the form must be chosen");
  FEDER_CHECK(!s.has_hard_rows, "hard rows are an index 3 system");
  unknown_.assign(3 * s.nodes, -1);
  for (int i = 0; i < 3 * s.nodes; ++i) {
    if (!(s.inverse_mass[i] > 0.0)) continue;
    unknown_[i] = static_cast<int>(coordinates_.size());
    coordinates_.push_back(i);
  }
  multiplier_.assign(s.rows, -1);
  for (int k = 0; k < s.rows; ++k) {
    if (!s.active(k)) continue;
    if (form == IdaForm::kCompliance) multiplier_[k] = 2 * coordinates() + static_cast<int>(rows_.size());
    rows_.push_back(k);
  }
  kkt_.prepare(s);
  lambda_ = rate_ = VectorXd::Zero(s.rows);
  rate_by_q_ = VectorXd::Zero(s.jacobian_size);
  find_pattern();
}

void IdaSystem::read(double t, const double* y, State& state) const {
  state.t = t;
  for (int i = 0; i < coordinates(); ++i) {
    state.q[coordinates_[i]] = y[i];
    state.v[coordinates_[i]] = y[coordinates() + i];
  }
  if (system_.driven()) {
    place_driven_nodes(system_, t, state.q);
    set_driven_velocities(system_, t, state.v);
  }
}

// q, v, phi, J, J v, lambda and the force at (t, y)
Status IdaSystem::evaluate(double t, const double* y) {
  const System& s = system_;
  for (int i = 0; i < unknowns(); ++i)
    if (!std::isfinite(y[i]))
      return Status::failure(StatusCode::kNonFinite,
                             "IDA unknown " + std::to_string(i) + " at t = " + std::to_string(t) + " s");
  read(t, y, state_);
  if (Status status = kkt_.evaluate(state_.q); !status.ok()) return status;
  if (s.has_damping) kkt_.multiply_jacobian(state_.v, rate_);
  for (int k : rows_)
    lambda_[k] =
        form_ == IdaForm::kOde ? -s.stiffness[k] * kkt_.phi[k] - s.damping[k] * rate_[k] : y[multiplier_[k]];

  evaluate_external_forces(s, state_, force_);
  if (s.forces.has_drag) force_.array() -= s.forces.drag.array() * state_.v.array();
  kkt_.add_jacobian_transpose(lambda_, force_);
  for (int i : coordinates_)
    if (!std::isfinite(force_[i]))
      return Status::failure(StatusCode::kNonFinite, "force on node " + std::to_string(i / 3) +
                                                         " at t = " + std::to_string(t) + " s");
  return {};
}

Status IdaSystem::initial(const State& state, double* y, double* y_prime) {
  const int n = coordinates();
  std::fill(y, y + unknowns(), 0.0);
  std::fill(y_prime, y_prime + unknowns(), 0.0);
  state_ = state;
  for (int i = 0; i < n; ++i) {
    y[i] = state.q[coordinates_[i]];
    y[n + i] = state.v[coordinates_[i]];
  }
  if (form_ == IdaForm::kCompliance) {
    if (Status status = evaluate(state.t, y); !status.ok()) return status;
    for (int k : rows_)
      y[multiplier_[k]] = -system_.stiffness[k] * kkt_.phi[k] - system_.damping[k] * rate_[k];
  }
  if (Status status = evaluate(state.t, y); !status.ok()) return status;
  for (int i = 0; i < n; ++i) {
    y_prime[i] = y[n + i];
    y_prime[n + i] = force_[coordinates_[i]] * system_.inverse_mass[coordinates_[i]];
  }
  return {};
}

Status IdaSystem::residual(double t, const double* y, const double* y_prime, double* r) {
  if (Status status = evaluate(t, y); !status.ok()) return status;
  const int n = coordinates();
  for (int i = 0; i < n; ++i) {
    r[i] = y_prime[i] - y[n + i];
    r[n + i] = system_.inertia[coordinates_[i]] * y_prime[n + i] - force_[coordinates_[i]];
  }
  if (form_ == IdaForm::kOde) return {};
  for (int k : rows_) {  // (d phi + b rate + lambda) / d, / b where d = 0
    const double d = system_.stiffness[k], b = system_.damping[k];
    r[multiplier_[k]] = d > 0.0 ? kkt_.phi[k] + b / d * rate_[k] + lambda_[k] / d : rate_[k] + lambda_[k] / b;
  }
  return {};
}

Status IdaSystem::jacobian(double t, const double* y, double cj, double* values) {
  if (Status status = evaluate(t, y); !status.ok()) return status;
  kkt_.set_geometric_stiffness(GeometricStiffness::kFull, 1.0, state_, lambda_);
  if (system_.has_damping) evaluate_rate_derivatives();
  std::fill(values, values + nonzeros(), 0.0);
  std::size_t next = 0;
  assemble(cj, [&](int, int, double value) { values[places_[next++]] += value; });
  for (int i = 0; i < nonzeros(); ++i)
    if (!std::isfinite(values[i]))
      return Status::failure(StatusCode::kNonFinite, "Jacobian at t = " + std::to_string(t) + " s");
  return {};
}

// d(J v)/dq of the stencil rows: row i is (Hess phi_i) v
void IdaSystem::evaluate_rate_derivatives() {
  std::size_t at = 0;
  for_each_stencil_row_type(system_.stencil_rows, [&](const auto& list) {
    using Row = typename std::decay_t<decltype(list)>::value_type;
    for (const Row& row : list) {
      const int columns = 3 * row.count();
      const Stencil& stencil = system_.stencils[at++];
      VectorXd v(columns);
      for (int c = 0; c < columns; ++c) v[c] = state_.v[3 * row.nodes[c / 3] + c % 3];
      for (int i = 0; i < Row::kRows; ++i) {
        Eigen::MatrixXd hessian(columns, columns);
        const Eigen::Matrix<double, Row::kRows, 1> unit = Eigen::Matrix<double, Row::kRows, 1>::Unit(i);
        row.hessian(state_.q.data(), unit.data(), hessian);
        Eigen::Map<VectorXd>(rate_by_q_.data() + stencil.jacobian + columns * i, columns) = hessian * v;
      }
    }
  });
}

template <class Visit>
void IdaSystem::for_each_element(Visit&& visit) const {
  const System& s = system_;
  Element e;
  auto set_nodes = [&](const int* nodes, int count) {
    e.columns = 3 * count;
    e.unknown.resize(e.columns);
    for (int c = 0; c < e.columns; ++c) e.unknown[c] = unknown_[3 * nodes[c / 3] + c % 3];
  };
  // distance rows: J = (-u, u), d(J v)/dq = (-w, w) with w = (E - u u^T) dv / l, K = g [P -P; -P P] with P =
  // E - u u^T
  for (int k = 0; k < s.distance.size(); ++k) {
    if (!s.distance.active(k)) continue;
    const int nodes[2] = {s.distance.a[k], s.distance.b[k]};
    const Vector3d u = kkt_.u.segment<3>(3 * k);
    const Vector3d dv = state_.v.segment<3>(3 * nodes[1]) - state_.v.segment<3>(3 * nodes[0]);
    const double inverse_length = kkt_.length[k] > 0.0 ? 1.0 / kkt_.length[k] : 0.0;
    const Vector3d w = inverse_length * (dv - u * u.dot(dv));
    const Matrix3d P = kkt_.geometric_distance[k] * (Matrix3d::Identity() - u * u.transpose());
    Eigen::Matrix<double, 6, 1> J, rate_by_q;
    J << -u, u;
    rate_by_q << -w, w;
    Eigen::Matrix<double, 6, 6> K;
    K << P, -P, -P, P;
    set_nodes(nodes, 2);
    e.rows = 1, e.first_row = k, e.J = J.data(), e.rate_by_q = rate_by_q.data(), e.K = K.data();
    visit(std::as_const(e));
  }
  for (const Stencil& stencil : s.stencils) {
    if (stencil.rows > 0 && !s.active(stencil.first_row)) continue;
    set_nodes(s.stencil_nodes.data() + stencil.first_node, stencil.nodes);
    e.rows = stencil.rows, e.first_row = stencil.first_row;
    e.J = kkt_.jacobian.data() + stencil.jacobian;
    e.rate_by_q = rate_by_q_.data() + stencil.jacobian;
    e.K = kkt_.geometric_stencil.data() + stencil.matrix;
    visit(std::as_const(e));
  }
}

template <class Sink>
void IdaSystem::assemble(double cj, Sink&& add) const {
  const int n = coordinates();
  for (int i = 0; i < n; ++i) {
    add(i, i, cj);
    add(i, n + i, -1.0);
    add(n + i, n + i, cj * system_.inertia[coordinates_[i]] + system_.forces.drag[coordinates_[i]]);
  }
  for_each_element([&](const Element& e) { assemble_element(e, add); });
}

template <class Sink>
void IdaSystem::assemble_element(const Element& e, Sink&& add) const {
  const int n = coordinates();
  for (int i = 0; i < e.columns; ++i)
    for (int j = 0; j < e.columns; ++j)
      if (e.unknown[i] >= 0 && e.unknown[j] >= 0) add(n + e.unknown[i], e.unknown[j], e.K[i * e.columns + j]);

  for (int k = 0; k < e.rows; ++k) {
    const double* J = e.J + k * e.columns;
    const double* rate_by_q = e.rate_by_q + k * e.columns;
    const double d = system_.stiffness[e.first_row + k], b = system_.damping[e.first_row + k];
    const double scale = multiplier_[e.first_row + k] < 0 ? 1.0 : 1.0 / (d > 0.0 ? d : b);
    const int multiplier = multiplier_[e.first_row + k];
    if (multiplier >= 0) add(multiplier, multiplier, scale);
    for (int j = 0; j < e.columns; ++j) {
      const int by_q = e.unknown[j], by_v = n + by_q;
      if (by_q < 0) continue;
      // of d phi + b J v, scaled
      const double row_by_q = scale * (d * J[j] + b * rate_by_q[j]), row_by_v = scale * b * J[j];
      if (multiplier >= 0) {
        add(by_v, multiplier, -J[j]);
        add(multiplier, by_q, row_by_q);
        if (b > 0.0) add(multiplier, by_v, row_by_v);
        continue;
      }
      for (int i = 0; i < e.columns; ++i) {
        if (e.unknown[i] < 0) continue;
        add(n + e.unknown[i], by_q, J[i] * row_by_q);
        if (b > 0.0) add(n + e.unknown[i], by_v, J[i] * row_by_v);
      }
    }
  }
}

void IdaSystem::find_pattern() {
  std::vector<std::pair<int, int>> terms;  // (column, row)
  assemble(1.0, [&](int row, int column, double) { terms.emplace_back(column, row); });
  std::vector<std::pair<int, int>> entries = terms;
  std::sort(entries.begin(), entries.end());
  entries.erase(std::unique(entries.begin(), entries.end()), entries.end());

  starts_.assign(unknowns() + 1, 0);
  indices_.reserve(entries.size());
  for (const auto& [column, row] : entries) {
    ++starts_[column + 1];
    indices_.push_back(row);
  }
  for (int i = 0; i < unknowns(); ++i) starts_[i + 1] += starts_[i];
  places_.reserve(terms.size());
  for (const auto& term : terms)
    places_.push_back(
        static_cast<int>(std::lower_bound(entries.begin(), entries.end(), term) - entries.begin()));
}

}  // namespace feder
