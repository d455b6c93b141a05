// Evaluation of rows and forces, and the parts of the step matrix (design.md section 1, notes E4, E5, E13).
//   spring:  lambda = -d phi - b phidot,  force J^T lambda        gamma = 1/(sigma d + rho b), b = d tau
//   distance row:  Hess phi = (E - u u^T)/l,  so sigma Kg = -sigma lambda/l (E - u u^T) on (b - a)
#include "engine/kkt.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/fluid/fluid.h"

namespace feder {
namespace {

// Visits every stencil row element with its Stencil: visit(row, stencil).
template <class Visit>
void for_each_stencil_row(const System& s, Visit&& visit) {
  std::size_t at = 0;
  for_each_stencil_row_type(s.stencil_rows, [&](const auto& list) {
    for (const auto& row : list) visit(row, s.stencils[at++]);
  });
}

Status first_non_finite(const System& s, const VectorXd& q) {
  for (int i = 0; i < s.nodes; ++i)
    if (!q.segment<3>(3 * i).allFinite())
      return Status::failure(StatusCode::kNonFinite,
                             "node " + std::to_string(i) + ": position is not finite");
  return {};
}

// Called only when the least squared length is 0 or not finite: names the culprit.
Status name_bad_distance(const System& s, const VectorXd& q) {
  const DistanceRows& rows = s.distance;
  for (int k = 0; k < rows.size(); ++k) {
    if (!rows.active(k)) continue;
    const double squared = (q.segment<3>(3 * rows.b[k]) - q.segment<3>(3 * rows.a[k])).squaredNorm();
    if (!std::isfinite(squared))
      return Status::failure(StatusCode::kNonFinite, s.row_name(k) + ": length is not finite");
    if (squared == 0.0 && rows.rest[k] > 0.0)
      return Status::failure(StatusCode::kSingular,
                             s.row_name(k) + ": its points coincide, the direction is undefined");
  }
  return first_non_finite(s, q);  // a padding slot met it
}

Status degenerate(const System& s, const Stencil& stencil, const VectorXd& q) {
  for (int i = 0; i < stencil.nodes; ++i)
    if (!q.segment<3>(3 * s.stencil_nodes[stencil.first_node + i]).allFinite())
      return Status::failure(StatusCode::kNonFinite,
                             s.row_name(stencil.first_row) + ": a position is not finite");
  return Status::failure(
      StatusCode::kSingular,
      s.row_name(stencil.first_row) + ": degenerate (an edge of length 0, or a straight or folded angle)");
}

// Relative residual of the second block row above which its scale is looked at more closely.
constexpr double kRestCheck = 1e-13;
constexpr double kRounding = 2e-15;

template <bool kDamped>
Status add_row_forces(const System& s, const State& state, VectorXd& f) {
  const Kernels& kernel = kernels();
  if (s.distance.size() > 0) {
    const bool damped = kDamped && s.distance.has_damping;
    const double smallest =
        damped ? kernel.damped_forces(s.distance_view(), state.q.data(), state.v.data(), f.data())
               : kernel.forces(s.distance_view(), state.q.data(), f.data());
    if (!(smallest > 0.0))
      if (Status status = name_bad_distance(s, state.q); !status.ok()) return status;
  }
  Status status;
  for_each_stencil_row(s, [&](const auto& row, const Stencil& stencil) {
    const double b = s.damping[stencil.first_row];
    if (!status.ok() || (row.stiffness == 0.0 && b == 0.0) || std::isinf(row.stiffness)) return;
    constexpr int kRows = std::decay_t<decltype(row)>::kRows;
    const int columns = 3 * row.count();
    double phi[kRows], jacobian[kRows * 3 * std::decay_t<decltype(row)>::kNodes];
    if (!row.evaluate(state.q.data(), phi, jacobian)) status = degenerate(s, stencil, state.q);
    for (int i = 0; i < kRows; ++i) {
      double lambda = -row.stiffness * phi[i];
      if constexpr (kDamped) {
        double rate = 0.0;
        for (int c = 0; c < columns; ++c)
          rate += jacobian[columns * i + c] * state.v[3 * row.nodes[c / 3] + c % 3];
        lambda -= b * rate;
      }
      for (int c = 0; c < columns; ++c) f[3 * row.nodes[c / 3] + c % 3] += lambda * jacobian[columns * i + c];
    }
  });
  return status;
}

}  // namespace

void evaluate_phi(const System& s, const VectorXd& q, VectorXd& phi) {
  phi.resize(s.rows);
  for (int k = 0; k < s.distance.size(); ++k)
    phi[k] = s.distance.active(k)
                 ? (q.segment<3>(3 * s.distance.b[k]) - q.segment<3>(3 * s.distance.a[k])).norm() -
                       s.distance.rest[k]
                 : 0.0;
  for_each_stencil_row(s, [&](const auto& row, const Stencil& stencil) {
    (void)row.evaluate(q.data(), phi.data() + stencil.first_row, nullptr);
  });
}

void evaluate_external_forces(const System& s, const State& state, VectorXd& f) {
  f = s.forces.constant;
  if (s.forces.has_torques) add_torques(s, state.q, f);
  for (const LawSpring& spring : s.law_springs)
    if (!spring.add_force(state.q.data(), state.v.data(), f.data()))
      f[3 * spring.nodes[0]] = std::numeric_limits<double>::quiet_NaN();
  if (s.forces.user) s.forces.user.force(state.t, state.q, state.v, f);
  if (s.fluid) s.fluid->add_forces(state.q, state.v, f);
  if (!s.forces.user && s.law_springs.empty() && !s.fluid) return;
  for (int i : s.masked) f[i] = 0.0;
}

namespace {

// Laws, fluids and user forces may have no value; nothing else here makes a bad number of good ones.
Status checked_external_forces(const System& s, const State& state, VectorXd& f) {
  evaluate_external_forces(s, state, f);
  if ((!s.forces.user && s.law_springs.empty() && !s.fluid) || f.allFinite()) return {};
  int node = 0;
  while (f.segment<3>(3 * node).allFinite()) ++node;
  return Status::failure(StatusCode::kNonFinite,
                         "the external force on node " + std::to_string(node) + " is not finite");
}

}  // namespace

Status evaluate_undamped_forces(const System& s, const State& state, VectorXd& f) {
  if (Status status = checked_external_forces(s, state, f); !status.ok()) return status;
  return add_row_forces<false>(s, state, f);
}

Status evaluate_forces(const System& s, const State& state, VectorXd& f) {
  if (Status status = checked_external_forces(s, state, f); !status.ok()) return status;
  if (s.forces.has_drag) f.array() -= s.forces.drag.array() * state.v.array();
  return add_row_forces<true>(s, state, f);
}

void Kkt::prepare(const System& s) {
  system = &s;
  const int n = 3 * s.nodes, md = s.distance.size();
  for (VectorXd* x : {&mass, &inverse_mass, &p, &scratch_v_}) *x = VectorXd::Zero(n);
  for (VectorXd* x : {&gamma, &inverse_gamma, &r, &phi, &scratch_y_}) *x = VectorXd::Zero(s.rows);
  u = VectorXd::Zero(3 * md);
  length = VectorXd::Zero(md);
  geometric_distance = VectorXd::Zero(md);
  jacobian = VectorXd::Zero(s.jacobian_size);
  geometric_stencil = VectorXd::Zero(s.matrix_size);
  geometric = false;
  dropped_.clear();
  sigma_ = rho_ = -1.0;
  set_step(1.0, 1.0);
}

void Kkt::set_step(double sigma, double rho) {
  if (sigma == sigma_ && rho == rho_) return;
  sigma_ = sigma;
  rho_ = rho;
  ++step_serial_;
  inert_distance_.clear();
  inert_stencil_.clear();
  mass = system->inertia + rho * system->forces.drag;
  inverse_mass = system->inverse_mass;
  for (int i = 0; i < mass.size(); ++i) {
    if (inverse_mass[i] > 0.0) inverse_mass[i] = 1.0 / mass[i];
  }
  for (int k = 0; k < system->rows; ++k) {
    const double d = system->stiffness[k];
    const bool hard = std::isinf(d);
    const double weight = hard ? d : sigma * d + rho * system->damping[k];
    const bool pushes = weight > 0.0;
    gamma[k] = pushes ? 1.0 / weight : 1.0;  // hard: 0
    inverse_gamma[k] = pushes && std::isfinite(weight) ? weight : 0.0;
    if (!pushes && k < system->distance.size()) inert_distance_.push_back(k);
  }
  for (std::size_t i = 0; i < system->stencils.size(); ++i) {
    const Stencil& stencil = system->stencils[i];
    if (stencil.rows > 0 && gamma[stencil.first_row] > 0.0 && inverse_gamma[stencil.first_row] == 0.0)
      inert_stencil_.push_back(static_cast<int>(i));
  }
  for (int k : dropped_) gamma[k] = 1.0;
}

Status Kkt::evaluate(const VectorXd& q, bool with_length) {
  const System& s = *system;
  if (s.distance.size() > 0) {
    const double smallest = kernels().evaluate(s.distance_view(), q.data(), u.data(),
                                               with_length ? length.data() : nullptr, phi.data());
    if (!(smallest > 0.0))
      if (Status status = name_bad_distance(s, q); !status.ok()) return status;
    for (int k : inert_distance_) {
      u.segment<3>(3 * k).setZero();
      phi[k] = 0.0;
    }
  }
  Status status;
  for_each_stencil_row(s, [&](const auto& row, const Stencil& stencil) {
    if (!row.evaluate(q.data(), phi.data() + stencil.first_row, jacobian.data() + stencil.jacobian) &&
        status.ok() && s.active(stencil.first_row))
      status = degenerate(s, stencil, q);
  });
  for (int i : inert_stencil_) {
    const Stencil& stencil = s.stencils[i];
    phi.segment(stencil.first_row, stencil.rows).setZero();
    jacobian.segment(stencil.jacobian, stencil.rows * 3 * stencil.nodes).setZero();
  }
  if (s.has_hard_rows) scale_ = q.head(3 * s.places()).lpNorm<Eigen::Infinity>();
  if (!dropped_.empty()) {
    dropped_phi_.setZero();
    dropped_jacobian_.setZero();
    swap_dropped();
  }
  return status;
}

void Kkt::take_spins_over_a_step(double dt, const VectorXd& v) {
  const System& s = *system;
  if (s.bodies.empty()) return;
  for (const Stencil& stencil : s.stencils)
    for (int i = 0; i < stencil.nodes; ++i) {
      const int node = s.stencil_nodes[stencil.first_node + i];
      if (node < s.places()) continue;
      using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
      Eigen::Map<Rows> J(jacobian.data() + stencil.jacobian, stencil.rows, 3 * stencil.nodes);
      J.middleCols<3>(3 * i) *= right_jacobian(dt * v.segment<3>(3 * node));
    }
}

namespace {

// Negative eigenvalues become `kept` times themselves; with 0 this is the nearest positive semidefinite
// matrix.
template <class Matrix>
void clamp_negative_part(Eigen::Map<Matrix> m, double kept) {
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(m);
  const auto& values = eigen.eigenvalues();
  m = eigen.eigenvectors() * values.cwiseMax(kept * values).asDiagonal() * eigen.eigenvectors().transpose();
}

}  // namespace

void Kkt::set_geometric_stiffness(GeometricStiffness kind, double sigma, const State& state,
                                  const VectorXd& lambda, double kept, double rho) {
  const System& s = *system;
  geometric = kind != GeometricStiffness::kOff;
  if (!geometric) return;
  const bool clamp = kind == GeometricStiffness::kClamped;
  for (int k = 0; k < s.distance.size(); ++k) {
    double tension = -lambda[k];
    if (clamp && tension < 0.0) tension *= kept;
    // zero rest length at zero length: the limit of d phi / l is d
    geometric_distance[k] = length[k] > 0.0 ? sigma * tension / length[k] : sigma * s.distance.spring[k];
  }
  for (int k : s.inactive_distance) geometric_distance[k] = 0.0;

  for_each_stencil_row(s, [&](const auto& row, const Stencil& stencil) {
    constexpr int kMost = 3 * std::decay_t<decltype(row)>::kNodes;
    const int size = 3 * row.count();
    using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMost, kMost>;
    Eigen::Map<Square> out(geometric_stencil.data() + stencil.matrix, size, size);
    row.hessian(state.q.data(), lambda.data() + stencil.first_row, out);
    out *= s.active(stencil.first_row) ? -sigma : 0.0;
    if (clamp) clamp_negative_part<Square>(out, kept);
  });

  std::size_t law = s.stencils.size() - s.forces.user.stencils.size() - s.law_springs.size();
  for (const LawSpring& spring : s.law_springs) {
    const int size = 3 * spring.count();
    Eigen::Map<Eigen::MatrixXd> out(geometric_stencil.data() + s.stencils[law++].matrix, size, size);
    spring.stiffness(state.q.data(), state.v.data(), sigma, rho, out);
    if (clamp) clamp_negative_part<Eigen::MatrixXd>(out, kept);
  }

  if (!s.forces.user.stiffness) return;
  const std::size_t first = s.stencils.size() - s.forces.user.stencils.size();
  if (first == s.stencils.size()) return;
  double* user = geometric_stencil.data() + s.stencils[first].matrix;
  s.forces.user.stiffness(state.t, state.q, state.v, user);
  for (std::size_t i = first; i < s.stencils.size(); ++i) {
    const int size = 3 * s.stencils[i].nodes;
    Eigen::Map<Eigen::MatrixXd> out(geometric_stencil.data() + s.stencils[i].matrix, size, size);
    out = (0.5 * sigma * (out + out.transpose())).eval();
    if (clamp) clamp_negative_part<Eigen::MatrixXd>(out, kept);
  }
}

Eigen::Map<Matrix3d> Kkt::node_block(int stencil) {
  geometric = true;
  return Eigen::Map<Matrix3d>(geometric_stencil.data() + system->stencils[stencil].matrix);
}

template <class Velocity>
void Kkt::multiply_stencils(Velocity&& velocity, VectorXd& out) const {
  for (const Stencil& stencil : system->stencils) {
    const int* nodes = system->stencil_nodes.data() + stencil.first_node;
    double* sum = out.data() + stencil.first_row;
    for (int row = 0; row < stencil.rows; ++row) sum[row] = 0.0;
    for (int i = 0; i < stencil.nodes; ++i) {
      const double x = velocity(3 * nodes[i]), y = velocity(3 * nodes[i] + 1), z = velocity(3 * nodes[i] + 2);
      const double* J = jacobian.data() + stencil.jacobian + 3 * i;
      for (int row = 0; row < stencil.rows; ++row, J += 3 * stencil.nodes)
        sum[row] += J[0] * x + J[1] * y + J[2] * z;
    }
  }
}

void Kkt::multiply_jacobian(const VectorXd& v, VectorXd& out) const {
  out.resize(system->rows);
  kernels().multiply(system->distance_view(), u.data(), v.data(), out.data());
  multiply_stencils([&](int i) { return v[i]; }, out);
}

void Kkt::multiply_jacobian_inverse_mass(const VectorXd& x, VectorXd& out) const {
  out.resize(system->rows);
  kernels().multiply_weighted(system->distance_view(), u.data(), inverse_mass.data(), x.data(), out.data());
  multiply_stencils([&](int i) { return inverse_mass[i] * x[i]; }, out);
}

void Kkt::add_jacobian_transpose(const VectorXd& y, VectorXd& out) const {
  const System& s = *system;
  kernels().add_transpose(s.distance_view(), u.data(), y.data(), out.data());
  for (const Stencil& stencil : s.stencils) {
    const int* nodes = s.stencil_nodes.data() + stencil.first_node;
    const double* weight = y.data() + stencil.first_row;
    for (int i = 0; i < stencil.nodes; ++i) {
      double sum[3] = {};
      const double* J = jacobian.data() + stencil.jacobian + 3 * i;
      for (int row = 0; row < stencil.rows; ++row, J += 3 * stencil.nodes)
        for (int c = 0; c < 3; ++c) sum[c] += J[c] * weight[row];
      for (int c = 0; c < 3; ++c) out[3 * nodes[i] + c] += sum[c];
    }
  }
}

void Kkt::add_geometric(const VectorXd& v, VectorXd& out) const {
  if (!geometric) return;
  const System& s = *system;
  for (int k = 0; k < s.distance.size(); ++k) {
    const int a = 3 * s.distance.a[k], b = 3 * s.distance.b[k];
    const Vector3d w = u.segment<3>(3 * k), dv = v.segment<3>(b) - v.segment<3>(a);
    const Vector3d f = geometric_distance[k] * (dv - w * w.dot(dv));
    out.segment<3>(a) -= f;
    out.segment<3>(b) += f;
  }
  for (const Stencil& stencil : s.stencils) {
    const int* nodes = s.stencil_nodes.data() + stencil.first_node;
    const double* K = geometric_stencil.data() + stencil.matrix;
    for (int i = 0; i < stencil.nodes; ++i)
      for (int j = 0; j < stencil.nodes; ++j)
        for (int c = 0; c < 9; ++c)
          out[3 * nodes[i] + c / 3] +=
              K[(3 * i + c / 3) * 3 * stencil.nodes + 3 * j + c % 3] * v[3 * nodes[j] + c % 3];
  }
}

ResidualSize Kkt::residual_size(const VectorXd& v, const VectorXd& y) const {
  return residual(v, y, nullptr, nullptr);
}

ResidualSize Kkt::residual(const VectorXd& v, const VectorXd& y, VectorXd* residual_v,
                           VectorXd* residual_y) const {
  const System& s = *system;
  if (residual_v) residual_v->resize(p.size());
  if (residual_y) residual_y->resize(r.size());
  auto relative = [](double error, double scale) { return scale > 0.0 ? error / scale : error; };
  auto larger = [](double x, double z) { return z > x || z != z ? z : x; };
  const Kernels& kernel = kernels();
  double sums[5];

  // first block row: p - Mt v + J^T y
  scratch_v_.setZero();
  add_jacobian_transpose(y, scratch_v_);
  double geometric_terms = 0.0;
  if (geometric) {
    scratch_geometric_.setZero(p.size());
    add_geometric(v, scratch_geometric_);
    for (int i : s.masked) scratch_geometric_[i] = 0.0;
    geometric_terms = scratch_geometric_.norm();
    scratch_v_ -= scratch_geometric_;
  }
  double masked_terms = 0.0;  // masked coordinates have no residual
  for (int i : s.masked) {
    scratch_v_[i] = mass[i] * v[i] - p[i];
    masked_terms += scratch_v_[i] * scratch_v_[i];
  }
  kernel.balance(p.size(), p.data(), -1.0, mass.data(), v.data(), scratch_v_.data(),
                 residual_v ? residual_v->data() : nullptr, sums);
  const double terms_v = std::sqrt(sums[0]) + std::sqrt(sums[1]) + geometric_terms,
               balance_v = std::sqrt(std::max(0.0, sums[2] - masked_terms));
  const double error_v = std::sqrt(sums[3]), size_v = std::sqrt(sums[4]);

  // second block row: r + gamma y + J v
  multiply_jacobian(v, scratch_y_);
  kernel.balance(r.size(), r.data(), 1.0, gamma.data(), y.data(), scratch_y_.data(),
                 residual_y ? residual_y->data() : nullptr, sums);
  const double terms_y = std::sqrt(sums[0]) + std::sqrt(sums[1]), balance_y = std::sqrt(sums[2]);
  double error_y = std::sqrt(sums[3]);

  // |J_k| is sqrt 2 for a distance row; a stencil row's is summed
  double row_forces = 2.0 * sums[4];
  for (const Stencil& stencil : s.stencils)
    for (int i = 0; i < stencil.rows; ++i) {
      const double size =
          jacobian.segment(stencil.jacobian + 3 * stencil.nodes * i, 3 * stencil.nodes).squaredNorm();
      row_forces += (size - 2.0) * y[stencil.first_row + i] * y[stencil.first_row + i];
    }
  // at rest every term of the second row vanishes: what is left is rounding of Mt^-1 p, which the rows had to
  // cancel
  if (error_y > kRestCheck * (terms_y + balance_y) &&
      error_y <= kRounding * inverse_mass.cwiseProduct(p).norm())
    error_y = 0.0;
  return {larger(relative(error_v, terms_v + std::sqrt(std::max(0.0, row_forces))),
                 relative(error_y, terms_y + 2.0 * size_v)),
          larger(relative(error_v, terms_v + balance_v), relative(error_y, terms_y + balance_y))};
}

}  // namespace feder
