// The step matrix of implicit Euler by Gauss-Seidel on its dual side:
//   v = (M + dt B)^-1 (M v_n + dt f),  y = 0,
// then per row g = gamma y + (phi(q') - memory phi(q_n))/dt is taken to 0. Ledger: M (v' - v_n) = dt f -
// dt B v' + (sum of J^T dy), multiplied by v'.
#include "solvers/xpbd.h"

#include <algorithm>
#include <cmath>

#include "engine/body.h"
#include "engine/check.h"
#include "solvers/step_row_solver.h"

namespace feder {
namespace {
// A sweep that moves v by less than this fraction of it has converged to rounding.
constexpr double kConverged = 2e-15;
}  // namespace

Status Xpbd::prepare() {
  FEDER_CHECK(options_.sweeps >= 1 && options_.substeps >= 1, "at least one sweep and one substep");
  kkt_.prepare(*system_);
  sweep_.prepare(*system_);
  order_ = sweep_.order();
  sweeps_ = 0;
  return {};
}

// v after everything that acts without a row
Status Xpbd::predict(double dt, const State& state) {
  const System& s = *system_;
  VectorXd& p = kkt_.p;
  if (s.forces_look_at_state()) {
    at_ = state;
    at_.t += dt;
    evaluate_external_forces(s, at_, p);
    if (!p.allFinite()) return Status::failure(StatusCode::kNonFinite, "an external force is not finite");
  } else {
    p = s.forces.constant;
  }
  v_start_ = state.v;
  if (!s.bodies.empty() && !step_gyroscopic_terms(s, dt, v_start_))
    return Status::failure(StatusCode::kNotConverged, "the implicit gyroscopic step does not converge");
  p = s.inertia.cwiseProduct(v_start_) + dt * p;
  kkt_.set_step(dt * dt, dt);
  next_.v = kkt_.inverse_mass.cwiseProduct(p);
  return {};
}

// memory phi(q_n). After a longer step hard rows close as slowly as in that one: what its sweeps left open
// would else be thrown shut.
void Xpbd::remember(double dt, double closing, const VectorXd& q) {
  const System& s = *system_;
  evaluate_phi(s, q, remembered_);
  for (int k = 0; k < s.rows; ++k) {
    double memory = s.memory(k, dt);
    if (closing > dt && std::isinf(s.stiffness[k])) memory = 1.0 - (1.0 - memory) * dt / closing;
    remembered_[k] *= memory;
  }
}

Status Xpbd::sweep_current(double dt, const State& start) {
  const System& s = *system_;
  advance(s, dt, next_.v, start.q, next_.q);
  place_driven_nodes(s, start.t + dt, next_.q);
  // turns are counted from the start's, not from where v leads without rows
  for (const TurnRow& row : std::get<std::vector<TurnRow>>(s.stencil_rows))
    next_.q[3 * row.dial.node + 1] = start.q[3 * row.dial.node + 1];
  sweep_.begin(dt, kkt_, remembered_, start.q);
  for (int i = 0; i < options_.sweeps; ++i) {
    double change = 0.0;
    const Status status =
        sweep_.sweep(options_.row_weights, next_.q, next_.v, y_, books_ ? &impulse_ : nullptr, change);
    if (!status.ok()) return status;
    ++sweeps_;
    if (change <= kConverged * std::sqrt(next_.v.dot(kkt_.mass.cwiseProduct(next_.v)))) break;
  }
  return {};
}

// J and the linear phi of the substep's start
Status Xpbd::sweep_frozen(double dt, const State& start) {
  const System& s = *system_;
  at_.q = start.q;
  place_driven_nodes(s, start.t + dt, at_.q);
  if (Status status = kkt_.evaluate(at_.q, false); !status.ok()) return status;
  kkt_.r = (kkt_.phi - remembered_) / dt;
  step_rows_of(kkt_, order_, frozen_);
  VectorXd y = VectorXd::Zero(frozen_.count());
  for (int i = 0; i < options_.sweeps; ++i) {
    const double change = sweep_step_rows(frozen_, kkt_.inverse_mass, next_.v, y, options_.row_weights);
    ++sweeps_;
    if (change <= kConverged * std::sqrt(next_.v.dot(kkt_.mass.cwiseProduct(next_.v)))) break;
  }
  for (int i = 0; i < frozen_.count(); ++i) y_[order_[i]] = y[i];
  if (books_) kkt_.add_jacobian_transpose(y_, impulse_);
  return {};
}

Status Xpbd::substep(double dt, double closing, State& state, EnergyLedger* ledger) {
  const System& s = *system_;
  next_.q.resize(state.q.size());
  if (Status status = predict(dt, state); !status.ok()) return status;
  remember(dt, closing, state.q);
  y_.setZero(s.rows);
  books_ = ledger != nullptr;
  if (books_) impulse_.setZero(state.v.size());
  if (Status status = options_.frozen_rows ? sweep_frozen(dt, state) : sweep_current(dt, state); !status.ok())
    return status;
  if (!next_.v.allFinite()) return Status::failure(StatusCode::kNonFinite, "a velocity is not finite");
  next_.t = state.t + dt;
  if (ledger) keep_books(dt, state, *ledger);
  advance(s, dt, next_.v, state.q, next_.q);
  drive(s, next_);
  std::swap(state, next_);
  return {};
}

// Adds to the ledger what one substep books; the change of the rows' energy is taken over the whole step.
void Xpbd::keep_books(double dt, const State& start, EnergyLedger& ledger) const {
  const System& s = *system_;
  const VectorXd &v = next_.v, dv = v - v_start_, gyroscopic = v_start_ - start.v;
  ledger.kinetic_change += kinetic_energy_change(s, start.v, v);
  ledger.external_work += (kkt_.p - s.inertia.cwiseProduct(v_start_)).dot(v);
  ledger.drag_work -= dt * s.forces.drag.cwiseProduct(v).dot(v);
  double row_work = 0.0;
  for (int i = 0; i < v.size(); ++i)
    if (kkt_.inverse_mass[i] > 0.0) row_work += impulse_[i] * v[i];
  ledger.row_work += row_work;
  ledger.numerical -=
      0.5 * (s.inertia.cwiseProduct(dv).dot(dv) + s.inertia.cwiseProduct(gyroscopic).dot(gyroscopic));
}

Status Xpbd::step(double dt, State& state, History& history, EnergyLedger* ledger) {
  const System& s = *system_;
  before_ = state;
  if (ledger) *ledger = {};
  const double row_energy_before = ledger ? row_energy(s, state) : 0.0;
  const double part = dt / options_.substeps, closing = std::max(dt, history.last_dt) / options_.substeps;
  for (int i = 0; i < options_.substeps; ++i)
    if (Status status = substep(part, closing, state, ledger); !status.ok()) {
      std::swap(state, before_);
      return status;
    }
  state.t = before_.t + dt;
  if (options_.substeps > 1) drive(s, state);
  if (ledger) ledger->row_change = row_energy(s, state) - row_energy_before;
  history.lambda = y_ / part;
  history.force.resize(0);
  history.last_dt = dt;
  ++counts_.steps;
  counts_.force_evaluations += options_.substeps;
  return {};
}

}  // namespace feder
