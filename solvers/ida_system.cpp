// The equations of motion as F(t, y, y') = 0 (see the header) and their Jacobian dF/dy + cj dF/dy'. With
// lambda(q, v) = -d phi - b J v the derivatives per row are
//   d(J^T lambda)/dq = lambda Hess + 1/2 [lambda J^T]x + J^T dlambda/dq,   d(J v)/dq = (Hess v + 1/2 v x
//   J^T)^T,
// the cross products at spins only, where q is turned on the right: phi(R exp xi exp eta) is phi of xi + eta
// + 1/2 xi x eta. -sum lambda Hess = Kg comes from Kkt, full and at sigma = 1. xi = 2 Im(conj(quaternion) d
// quaternion)/|quaternion|^2 leads from the four numbers IDA sees; rows are evaluated at the normalised one.
// The derivative of M^-1 J^T mu by q is left out: mu vanishes with the error. The pattern is found once by
// recording where every term goes; later fills walk through the terms in the same order.
#include "solvers/ida_system.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "engine/check.h"
#include "engine/row_rates.h"
#include "solvers/linear/linear_solver.h"

namespace feder {
namespace {

// G with quaternion' = 1/2 G w; G^T G = |quaternion|^2 E.
Eigen::Matrix<double, 4, 3> rate_matrix(const double* q) {
  Eigen::Matrix<double, 4, 3> G;
  G << -q[1], -q[2], -q[3], q[0], -q[3], q[2], q[3], q[0], -q[1], -q[2], q[1], q[0];
  return G;
}

}  // namespace

IdaSystem::IdaSystem(const System& s, const State& state, IdaForm form)
    : system_(s), form_(form), state_(state) {
  FEDER_CHECK(form != IdaForm::kAutomatic, "the form must be chosen");
  FEDER_CHECK(s.has_hard_rows == (form == IdaForm::kGgl), "hard rows are the ggl form's");
  unknown_.assign(3 * s.nodes, -1);
  position_.assign(3 * s.nodes, -1);
  for (int i = 0; i < 3 * s.nodes; ++i) {
    if (!(s.inverse_mass[i] > 0.0)) continue;
    unknown_[i] = static_cast<int>(coordinates_.size());
    coordinates_.push_back(i);
    if (i < 3 * s.places()) position_[i] = positions_++;
  }
  for (std::size_t i = 0; i < s.bodies.size(); ++i) {
    const int spin = s.bodies[i].spin;
    if (!s.free[spin]) continue;
    turning_.push_back(static_cast<int>(i));
    for (int c = 0; c < 3; ++c) position_[3 * spin + c] = positions_;
    positions_ += 4;
  }
  multiplier_.assign(s.rows, -1);
  for (int k = 0; k < s.rows; ++k) {
    if (!s.active(k)) continue;
    if (form == IdaForm::kCompliance || std::isinf(s.stiffness[k]))
      multiplier_[k] = positions_ + coordinates() + multipliers_++;
    rows_.push_back(k);
  }
  kkt_.prepare(s);
  lambda_ = mu_ = rate_ = VectorXd::Zero(s.rows);
  slide_ = row_force_ = VectorXd::Zero(3 * s.nodes);
  rate_by_q_ = VectorXd::Zero(s.jacobian_size);
  find_pattern();
}

void IdaSystem::read(double t, const double* y, State& state) const {
  state.t = t;
  for (int i = 0; i < coordinates(); ++i) {
    const int c = coordinates_[i];
    if (c < 3 * system_.places()) state.q[c] = y[position_[c]];
    state.v[c] = y[positions_ + i];
  }
  for (int i : turning_) {
    const Body& b = system_.bodies[i];
    std::copy_n(y + position_[3 * b.spin], 4, state.q.data() + b.quaternion);
    normalise(state.q.data() + b.quaternion);
  }
  drive(system_, state);
}

// q, v, phi, J, J v, lambda, mu and the force at (t, y)
Status IdaSystem::evaluate(double t, const double* y) {
  const System& s = system_;
  for (int i = 0; i < unknowns(); ++i)
    if (!std::isfinite(y[i]))
      return Status::failure(StatusCode::kNonFinite,
                             "IDA unknown " + std::to_string(i) + " at t = " + std::to_string(t) + " s");
  read(t, y, state_);
  if (Status status = kkt_.evaluate(state_.q); !status.ok()) return status;
  if (s.has_damping || s.has_hard_rows) kkt_.multiply_jacobian(state_.v, rate_);
  for (int k : rows_) {
    lambda_[k] =
        multiplier_[k] < 0 ? -s.stiffness[k] * kkt_.phi[k] - s.damping[k] * rate_[k] : y[multiplier_[k]];
    if (hard(k)) mu_[k] = y[multiplier_[k] + multipliers_];
  }
  row_force_.setZero();
  kkt_.add_jacobian_transpose(lambda_, row_force_);
  if (form_ == IdaForm::kGgl) {
    slide_.setZero();
    kkt_.add_jacobian_transpose(mu_, slide_);
    slide_ = slide_.cwiseProduct(s.inverse_mass);
  }

  evaluate_external_forces(s, state_, force_);
  if (s.forces.has_drag) force_.array() -= s.forces.drag.array() * state_.v.array();
  add_gyroscopic_torques(s, state_.v, force_);
  force_ += row_force_;
  for (int i : coordinates_)
    if (!std::isfinite(force_[i]))
      return Status::failure(StatusCode::kNonFinite, "force on node " + std::to_string(i / 3) +
                                                         " at t = " + std::to_string(t) + " s");
  return {};
}

// Hard rows: [M, -J^T; -J, 0] (a, lambda) = (f, Jdot v + phi_tt), with the hard lambda still 0 in f.
Status IdaSystem::initial_multipliers(const State& state, double* y, VectorXd& a) {
  constexpr double kClosed = 1e-8;
  const System& s = system_;
  Kkt kkt = kkt_;
  kkt.set_step(0.0, 0.0);
  LinearSolver solver("auto");
  if (Status status = solver.analyze(s, false); !status.ok()) return status;
  if (Status status = kkt.evaluate(state.q); !status.ok()) return status;
  for (int k : rows_)
    if (hard(k) && !(std::abs(kkt.phi[k]) <= kClosed * kkt.scale() &&
                     std::abs(rate_[k]) <= kClosed * (1.0 + state.v.lpNorm<Eigen::Infinity>())))
      return Status::failure(StatusCode::kRefused, "IDA: " + s.row_name(k) + " starts open by " +
                                                       std::to_string(kkt.phi[k]) + " m, at the rate " +
                                                       std::to_string(rate_[k]) + " m/s");
  kkt.p = force_;
  for (int i : s.masked) kkt.p[i] = 0.0;
  jacobian_rate(s, state, kkt.r);
  VectorXd driven, y_rows;
  driven_accelerations(s, state.t, driven);
  kkt.multiply_jacobian(driven, y_rows);
  for (int k : rows_)
    if (hard(k)) kkt.r[k] += y_rows[k];
  if (Status status = solver.factor(kkt); !status.ok()) return status;
  if (!kkt.dropped().empty())
    return Status::failure(StatusCode::kRefused,
                           "IDA: " + s.row_name(kkt.dropped()[0]) + " depends on other hard rows");
  const SolveReport report = solver.solve(kkt, a, y_rows);
  for (int k : rows_)
    if (hard(k)) y[multiplier_[k]] = y_rows[k];
  return report.status;
}

Status IdaSystem::initial(const State& state, double* y, double* y_prime) {
  const int n = coordinates();
  std::fill(y, y + unknowns(), 0.0);
  std::fill(y_prime, y_prime + unknowns(), 0.0);
  state_ = state;
  for (int i = 0; i < n; ++i) {
    const int c = coordinates_[i];
    if (c < 3 * system_.places()) y[position_[c]] = state.q[c];
    y[positions_ + i] = state.v[c];
  }
  for (int i : turning_) {
    const Body& b = system_.bodies[i];
    std::copy_n(state.q.data() + b.quaternion, 4, y + position_[3 * b.spin]);
    quaternion_rate(state.q.data() + b.quaternion, state.v.segment<3>(3 * b.spin),
                    y_prime + position_[3 * b.spin]);
  }
  if (Status status = evaluate(state.t, y); !status.ok()) return status;
  VectorXd a;
  if (form_ == IdaForm::kCompliance)
    for (int k : rows_)
      y[multiplier_[k]] = -system_.stiffness[k] * kkt_.phi[k] - system_.damping[k] * rate_[k];
  if (form_ == IdaForm::kGgl)
    if (Status status = initial_multipliers(state, y, a); !status.ok()) return status;
  if (Status status = evaluate(state.t, y); !status.ok()) return status;
  for (int i = 0; i < n; ++i) {
    const int c = coordinates_[i];
    if (c < 3 * system_.places()) y_prime[position_[c]] = y[positions_ + i];
    y_prime[positions_ + i] = force_[c] * system_.inverse_mass[c];
  }
  return {};
}

Status IdaSystem::residual(double t, const double* y, const double* y_prime, double* r) {
  if (Status status = evaluate(t, y); !status.ok()) return status;
  const bool ggl = form_ == IdaForm::kGgl;
  for (int i = 0; i < coordinates(); ++i) {
    const int c = coordinates_[i], at = positions_ + i;
    if (c < 3 * system_.places()) r[position_[c]] = y_prime[position_[c]] - y[at] - (ggl ? slide_[c] : 0.0);
    r[at] = system_.inertia[c] * y_prime[at] - force_[c];
  }
  for (int i : turning_) {
    const Body& b = system_.bodies[i];
    const int at = position_[3 * b.spin];
    Vector3d w = state_.v.segment<3>(3 * b.spin);
    if (ggl) w += slide_.segment<3>(3 * b.spin);
    Eigen::Map<Eigen::Vector4d>(r + at) =
        Eigen::Map<const Eigen::Vector4d>(y_prime + at) - 0.5 * rate_matrix(y + at) * w;
  }
  for (int k : rows_) {
    if (multiplier_[k] < 0) continue;
    const double d = system_.stiffness[k], b = system_.damping[k];
    double& own = r[multiplier_[k]];
    if (ggl) {
      own = kkt_.phi[k];
      r[multiplier_[k] + multipliers_] = rate_[k];
    } else {  // (d phi + b rate + lambda) / d, / b where d = 0
      own = d > 0.0 ? kkt_.phi[k] + b / d * rate_[k] + lambda_[k] / d : rate_[k] + lambda_[k] / b;
    }
  }
  return {};
}

Status IdaSystem::jacobian(double t, const double* y, double cj, double* values) {
  if (Status status = evaluate(t, y); !status.ok()) return status;
  for (int i : turning_) {  // as IDA sees it, not normalised: assemble needs its length
    const Body& b = system_.bodies[i];
    std::copy_n(y + position_[3 * b.spin], 4, state_.q.data() + b.quaternion);
  }
  State unit = state_;
  normalise_quaternions(system_, unit.q);
  kkt_.set_geometric_stiffness(GeometricStiffness::kFull, 1.0, unit, lambda_);
  if (system_.has_damping || system_.has_hard_rows) evaluate_rate_derivatives();
  std::fill(values, values + nonzeros(), 0.0);
  std::size_t next = 0;
  assemble(cj, [&](int, int, double value) { values[places_[next++]] += value; });
  for (int i = 0; i < nonzeros(); ++i)
    if (!std::isfinite(values[i]))
      return Status::failure(StatusCode::kNonFinite, "Jacobian at t = " + std::to_string(t) + " s");
  return {};
}

// d(J v)/dq of the stencil rows: row i is (Hess phi_i) v, and 1/2 v x J_i at spins
void IdaSystem::evaluate_rate_derivatives() {
  VectorXd q = state_.q;
  normalise_quaternions(system_, q);
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
        row.hessian(q.data(), unit.data(), hessian);
        Eigen::Map<VectorXd> out(rate_by_q_.data() + stencil.jacobian + columns * i, columns);
        out = hessian * v;
        const Eigen::Map<const VectorXd> J(kkt_.jacobian.data() + stencil.jacobian + columns * i, columns);
        for (int k = 0; k < stencil.nodes; ++k)
          if (row.nodes[k] >= system_.places())
            out.template segment<3>(3 * k) +=
                0.5 * Vector3d(v.segment<3>(3 * k)).cross(Vector3d(J.template segment<3>(3 * k)));
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
    e.coordinate.resize(e.columns);
    for (int c = 0; c < e.columns; ++c) {
      e.coordinate[c] = 3 * nodes[c / 3] + c % 3;
      e.unknown[c] = unknown_[e.coordinate[c]];
    }
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

// A derivative by a coordinate along the exponential map, as one by the numbers IDA sees.
template <class Sink>
void IdaSystem::add_by_position(int row, int coordinate, double value, Sink&& add) const {
  const int at = position_[coordinate];
  if (at < 0) return;
  if (coordinate < 3 * system_.places()) {
    add(row, at, value);
    return;
  }
  const Body& b = system_.bodies[static_cast<std::size_t>(coordinate / 3 - system_.places())];
  const double* quaternion = state_.q.data() + b.quaternion;
  const auto G = rate_matrix(quaternion);
  const double scale = 2.0 / Eigen::Map<const Eigen::Vector4d>(quaternion).squaredNorm();
  for (int j = 0; j < 4; ++j) add(row, at + j, value * scale * G(j, coordinate % 3));
}

// q' - G (v + slide)
template <class Sink>
void IdaSystem::assemble_kinematics(double cj, Sink&& add) const {
  for (int i = 0; i < coordinates(); ++i) {
    const int c = coordinates_[i];
    if (c >= 3 * system_.places()) continue;
    add(position_[c], position_[c], cj);
    add(position_[c], positions_ + i, -1.0);
  }
  for (int i : turning_) {
    const Body& b = system_.bodies[i];
    const int at = position_[3 * b.spin];
    Vector3d w = state_.v.segment<3>(3 * b.spin);
    if (form_ == IdaForm::kGgl) w += slide_.segment<3>(3 * b.spin);
    const auto G = rate_matrix(state_.q.data() + b.quaternion);
    // quaternion (0, w) as a matrix times the quaternion
    Eigen::Matrix4d right;
    right << 0.0, -w[0], -w[1], -w[2], w[0], 0.0, w[2], -w[1], w[1], -w[2], 0.0, w[0], w[2], w[1], -w[0], 0.0;
    for (int r = 0; r < 4; ++r) {
      for (int c = 0; c < 4; ++c) add(at + r, at + c, (r == c ? cj : 0.0) - 0.5 * right(r, c));
      for (int c = 0; c < 3; ++c)
        if (unknown_[3 * b.spin + c] >= 0) add(at + r, positions_ + unknown_[3 * b.spin + c], -0.5 * G(r, c));
    }
  }
}

// What turns with a body: w x I w by w, the constant torque R^T T and 1/2 [J^T lambda]x by xi.
template <class Sink>
void IdaSystem::assemble_turning(Sink&& add) const {
  for (int i : turning_) {
    const Body& b = system_.bodies[i];
    const Vector3d w = state_.v.segment<3>(3 * b.spin), g = row_force_.segment<3>(3 * b.spin);
    Eigen::Vector4d unit = state_.q.segment<4>(b.quaternion).normalized();
    const Matrix3d by_w = skew(w) * b.moments.asDiagonal() - skew(b.moments.cwiseProduct(w));
    const Matrix3d by_xi = -skew(rotation_matrix(unit.data()).transpose() * b.torque) - 0.5 * skew(g);
    for (int r = 0; r < 3; ++r) {
      const int row = unknown_[3 * b.spin + r];
      if (row < 0) continue;
      for (int c = 0; c < 3; ++c) {
        if (unknown_[3 * b.spin + c] >= 0)
          add(positions_ + row, positions_ + unknown_[3 * b.spin + c], by_w(r, c));
        add_by_position(positions_ + row, 3 * b.spin + c, by_xi(r, c), add);
      }
    }
  }
}

template <class Sink>
void IdaSystem::assemble(double cj, Sink&& add) const {
  assemble_kinematics(cj, add);
  for (int i = 0; i < coordinates(); ++i)
    add(positions_ + i, positions_ + i,
        cj * system_.inertia[coordinates_[i]] + system_.forces.drag[coordinates_[i]]);
  assemble_turning(add);
  for_each_element([&](const Element& e) { assemble_element(e, add); });
}

template <class Sink>
void IdaSystem::assemble_element(const Element& e, Sink&& add) const {
  for (int i = 0; i < e.columns; ++i)
    for (int j = 0; j < e.columns; ++j)
      if (e.unknown[i] >= 0)
        add_by_position(positions_ + e.unknown[i], e.coordinate[j], e.K[i * e.columns + j], add);

  for (int k = 0; k < e.rows; ++k) {
    const double* J = e.J + k * e.columns;
    const double* rate_by_q = e.rate_by_q + k * e.columns;
    const int row = e.first_row + k, multiplier = multiplier_[row];
    const double d = system_.stiffness[row], b = system_.damping[row];
    const double scale = multiplier < 0 ? 1.0 : 1.0 / (d > 0.0 ? d : b);
    const bool rigid = hard(row);
    if (multiplier >= 0 && !rigid) add(multiplier, multiplier, scale);
    for (int j = 0; j < e.columns; ++j) {
      const int c = e.coordinate[j], by_v = positions_ + e.unknown[j];
      if (rigid) {  // phi, J v, and mu in q'
        add_by_position(multiplier, c, J[j], add);
        add_by_position(multiplier + multipliers_, c, rate_by_q[j], add);
        if (e.unknown[j] < 0) continue;
        add(multiplier + multipliers_, by_v, J[j]);
        add(by_v, multiplier, -J[j]);
        const double slide = system_.inverse_mass[c] * J[j];
        if (c < 3 * system_.places()) {
          add(position_[c], multiplier + multipliers_, -slide);
        } else {
          const Body& body = system_.bodies[static_cast<std::size_t>(c / 3 - system_.places())];
          const auto G = rate_matrix(state_.q.data() + body.quaternion);
          for (int r = 0; r < 4; ++r)
            add(position_[c] + r, multiplier + multipliers_, -0.5 * G(r, c % 3) * slide);
        }
        continue;
      }
      // of d phi + b J v, scaled
      const double row_by_q = scale * (d * J[j] + b * rate_by_q[j]), row_by_v = scale * b * J[j];
      if (multiplier >= 0) {
        add_by_position(multiplier, c, row_by_q, add);
        if (e.unknown[j] < 0) continue;
        add(by_v, multiplier, -J[j]);
        if (b > 0.0) add(multiplier, by_v, row_by_v);
        continue;
      }
      for (int i = 0; i < e.columns; ++i) {
        if (e.unknown[i] < 0) continue;
        add_by_position(positions_ + e.unknown[i], c, J[i] * row_by_q, add);
        if (b > 0.0 && e.unknown[j] >= 0) add(positions_ + e.unknown[i], by_v, J[i] * row_by_v);
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
