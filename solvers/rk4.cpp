// Stages k_i = (v_i, M^-1 f_i) at (q, v) + a_i dt k_(i-1), a = 0, 1/2, 1/2, 1; weights 1/6, 1/3, 1/3, 1/6.
// Quaternions are numbers like others (stages off the unit sphere by O(dt^2)) until the step is complete;
// only then normalised. Its ledger: v' - v = sum_i b_i dt M^-1 f_i is a sum of kicks, each with the mean
// velocity (v + v')/2 of the whole step.
#include "solvers/rk4.h"

#include <cmath>
#include <cstdio>

#include "engine/row_rates.h"
#include "solvers/impulse_ledger.h"

namespace feder {
namespace {
constexpr double kNode[4] = {0.0, 0.5, 0.5, 1.0};
constexpr double kWeight[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};

// Of a projection that came to no end: the row that is open the most.
Status stays_open(const Kkt& kkt) {
  int worst = 0;
  for (int k = 0; k < kkt.phi.size(); ++k)
    if (kkt.gamma[k] == 0.0 && !(std::abs(kkt.phi[k]) <= std::abs(kkt.phi[worst]))) worst = k;
  char text[96];
  std::snprintf(text, sizeof text, " stays open by %.1e m or rad after the step: too long, or a row out of reach",
                std::abs(kkt.phi[worst]));
  return Status::failure(StatusCode::kNotConverged, kkt.system->row_name(worst) + text);
}

}  // namespace

Status Rk4::prepare() {
  matrix_.reset();
  if (!system_->has_hard_rows) return {};
  matrix_ = std::make_unique<Matrix>(Matrix{{}, LinearSolver(options_.route, options_.solve), {}, {}, {}});
  matrix_->kkt.prepare(*system_);
  matrix_->kkt.set_step(0.0, 0.0);  // only hard rows act
  return matrix_->solver.analyze(*system_, false);
}

// force += J^T lambda with J a + Jdot v + phi_tt = 0
Status Rk4::hold_rows(const State& at, VectorXd& force) {
  const System& s = *system_;
  Kkt& kkt = matrix_->kkt;
  if (Status status = kkt.evaluate(at.q, false); !status.ok()) return status;
  kkt.p = force;
  for (int i : s.masked) kkt.p[i] = 0.0;
  jacobian_rate(s, at, kkt.r);
  if (s.driven()) {
    driven_accelerations(s, at.t, matrix_->driven);
    kkt.multiply_jacobian(matrix_->driven, matrix_->a);
    kkt.r += matrix_->a;
  }
  if (Status status = matrix_->solver.factor(kkt); !status.ok()) return status;
  for (int k : kkt.dropped()) kkt.r[k] = 0.0;
  if (Status status = matrix_->solver.solve(kkt, matrix_->a, matrix_->y).status; !status.ok()) return status;
  force = s.inertia.cwiseProduct(matrix_->a);
  return {};
}

// q onto phi = 0 by Newton, then v onto J v + phi_t = 0, both by the least change in the metric of M
Status Rk4::project(State& at) {
  constexpr int kMostCorrections = 20;
  constexpr double kRounding = 4.0 * 2.2e-16, kClosed = 1e-9;
  const System& s = *system_;
  Kkt& kkt = matrix_->kkt;
  double before = HUGE_VAL;
  for (int i = 0;; ++i) {
    if (Status status = kkt.evaluate(at.q, false); !status.ok()) return status;
    if (Status status = matrix_->solver.factor(kkt); !status.ok()) return status;
    const double open = kkt.kept_gap();
    if (i == 0) counts_.position_drift = std::max(counts_.position_drift, open);
    if (open <= kRounding * kkt.scale() || (open <= kClosed * kkt.scale() && !(open < before))) break;
    if (!std::isfinite(open) || i == kMostCorrections) return stays_open(kkt);
    before = open;
    kkt.p.setZero();
    kkt.r = kkt.phi;
    if (Status status = matrix_->solver.solve(kkt, matrix_->a, matrix_->y).status; !status.ok())
      return status;
    advance(s, 1.0, matrix_->a, at.q, at.q);
    place_driven_nodes(s, at.t, at.q);
  }
  kkt.p = s.inertia.cwiseProduct(at.v);
  for (int i : s.masked) kkt.p[i] = 0.0;
  kkt.r.setZero();
  if (s.driven()) {
    matrix_->driven.setZero(at.v.size());
    set_driven_velocities(s, at.t, matrix_->driven);
    kkt.multiply_jacobian(matrix_->driven, kkt.r);
  }
  kkt.multiply_jacobian(at.v, matrix_->y);
  for (int k = 0; k < s.rows; ++k)
    if (kkt.gamma[k] == 0.0)
      counts_.velocity_drift = std::max(counts_.velocity_drift, std::abs(matrix_->y[k]));
  if (Status status = matrix_->solver.solve(kkt, at.v, matrix_->y).status; !status.ok()) return status;
  set_driven_velocities(s, at.t, at.v);
  return {};
}

// v holds the velocities of driven nodes, so phidot = J v.
Status Rk4::row_forces(const State& at, VectorXd& lambda) {
  const System& s = *system_;
  if (!finite_) {
    finite_ = std::make_unique<Kkt>();
    finite_->prepare(s);
    finite_->set_step(1.0, 1.0);
  }
  if (Status status = finite_->evaluate(at.q); !status.ok()) return status;
  VectorXd rate;
  finite_->multiply_jacobian(at.v, rate);
  lambda.setZero(s.rows);
  for (int k = 0; k < s.rows; ++k)
    if (std::isfinite(s.stiffness[k]))
      lambda[k] = -s.stiffness[k] * finite_->phi[k] - s.damping[k] * rate[k];
  if (!matrix_) return {};
  VectorXd force;
  if (Status status = evaluate_forces(s, at, force); !status.ok()) return status;
  add_gyroscopic_torques(s, at.v, force);
  if (Status status = hold_rows(at, force); !status.ok()) return status;
  for (int k = 0; k < s.rows; ++k)
    if (std::isinf(s.stiffness[k])) lambda[k] = matrix_->y[k];
  return {};
}

Status Rk4::step(double dt, State& state, History& history, EnergyLedger* ledger) {
  const System& s = *system_;
  const auto W = s.inverse_mass.array();
  ImpulseLedger record(s, state, ledger);
  std::array<State, 4> stages;  // kept only for the ledger

  for (int i = 0; i < 4; ++i) {
    stage_ = state;
    if (i > 0) {
      stage_.q += kNode[i] * dt * rate_[i - 1];
      stage_.v.array() += kNode[i] * dt * W * force_[i - 1].array();
      stage_.t += kNode[i] * dt;
      drive(s, stage_);
    }
    if (Status status = evaluate_forces(s, stage_, force_[i]); !status.ok()) return status;
    add_gyroscopic_torques(s, stage_.v, force_[i]);
    if (matrix_)
      if (Status status = hold_rows(stage_, force_[i]); !status.ok()) return status;
    position_rate(s, stage_.q, stage_.v, rate_[i]);
    if (ledger) stages[i] = stage_;
  }
  ++counts_.steps, counts_.force_evaluations += 4;

  stage_ = state;
  for (int i = 0; i < 4; ++i) {
    stage_.q += kWeight[i] * dt * rate_[i];
    stage_.v.array() += kWeight[i] * dt * W * force_[i].array();
  }
  normalise_quaternions(s, stage_.q);
  stage_.t += dt;
  drive(s, stage_);
  const VectorXd free = ledger ? stage_.v : VectorXd();
  if (matrix_)
    if (Status status = project(stage_); !status.ok()) return status;
  if (ledger) ledger->numerical = kinetic_energy_change(s, free, stage_.v);  // of the projection
  if (ledger)
    for (int i = 0; i < 4; ++i) record.kick(kWeight[i] * dt, stages[i], force_[i], state.v, free);
  std::swap(state, stage_);
  history.force.resize(0);
  record.close(state);
  return {};
}

}  // namespace feder
