// Leapfrog with velocity-implicit second kick; RATTLE with hard rows. History::force holds F(q, v) of the
// last step's end: the next first kick needs no new evaluation. With C = B + J^T b J the second kick is (M +
// dt/2 C) v' = M v+ + dt/2 F0(q'), F0 without damping.
#include "solvers/leapfrog.h"

#include <cmath>
#include <cstdio>

#include "solvers/impulse_ledger.h"

namespace feder {

Leapfrog::Leapfrog(const System& system, const IntegratorOptions& options)
    : system_(&system), options_(options) {}

Status Leapfrog::prepare() {
  matrix_.reset();
  if (!system_->has_damping && !system_->has_hard_rows) return {};
  matrix_ = std::make_unique<Matrix>(Matrix{{}, LinearSolver(options_.route, options_.solve), {}, {}, {}});
  matrix_->kkt.prepare(*system_);
  return matrix_->solver.analyze(*system_, false);
}

// (M + dt/2 C) v' = M v + dt/2 F0 with J v' = 0 on hard rows
Status Leapfrog::solve_kick(double dt, const State& half, VectorXd& v_next) {
  Kkt& kkt = matrix_->kkt;
  kkt.set_step(0.0, 0.5 * dt);
  if (Status status = kkt.evaluate(half.q, false); !status.ok()) return status;
  kkt.p.array() = system_->inertia.array() * half.v.array() + 0.5 * dt * force_.array();
  for (int i : system_->masked) kkt.p[i] = 0.0;
  kkt.r.setZero();
  if (system_->driven()) {  // phi_t
    v_next.setZero(half.v.size());
    set_driven_velocities(*system_, half.t, v_next);
    kkt.multiply_jacobian(v_next, kkt.r);
  }
  if (Status status = matrix_->solver.factor(kkt); !status.ok()) return status;
  const Status status = matrix_->solver.solve(kkt, v_next, matrix_->y).status;
  set_driven_velocities(*system_, half.t, v_next);
  return status;
}

// Drift that ends on the hard rows: w += W J(q)^T y until phi(q') = 0, by corrections of J(q) dv =
// -phi(q')/dt. Contracts by O(dt) each.
Status Leapfrog::drift_on_rows(double dt, const VectorXd& q, VectorXd& w, State& next) {
  constexpr int kMostCorrections = 100;
  constexpr double kRounding = 4.0 * 2.2e-16, kClosed = 1e-11;
  const System& s = *system_;
  Kkt& kkt = matrix_->kkt;
  kkt.set_step(0.0, 0.0);  // only hard rows act
  if (Status status = kkt.evaluate(q, false); !status.ok()) return status;
  if (Status status = matrix_->solver.factor(kkt); !status.ok()) return status;
  kkt.p.setZero();
  const double size = q.lpNorm<Eigen::Infinity>();
  double before = HUGE_VAL;
  for (int i = 0; i < kMostCorrections; ++i) {
    next.v = w;
    drift(dt, q, next);
    place_driven_nodes(s, next.t, next.q);
    evaluate_phi(s, next.q, matrix_->phi);
    double open = 0.0;
    for (int k = 0; k < s.rows; ++k) {
      kkt.r[k] = kkt.gamma[k] == 0.0 ? matrix_->phi[k] / dt : 0.0;
      open = std::max(open, std::abs(dt * kkt.r[k]));
    }
    if (open <= kRounding * size || (open <= kClosed * size && open > 0.5 * before)) return {};
    if (!std::isfinite(open) || i + 1 == kMostCorrections) break;
    before = open;
    if (Status status = matrix_->solver.solve(kkt, matrix_->dv, matrix_->y).status; !status.ok())
      return status;
    w += matrix_->dv;
  }
  char text[112];
  std::snprintf(text, sizeof text,
                "the drift does not end on the hard rows: %.1e stays open, the step is too long", before);
  return Status::failure(StatusCode::kNotConverged, text);
}

// Particles and centres move straight, bodies turn freely.
void Leapfrog::drift(double dt, const VectorXd& q, State& next) const {
  const System& s = *system_;
  kernels().drift(3 * s.places(), dt, next.v.data(), q.data(), next.q.data());
  for (const Body& b : s.bodies) {
    next.q.segment<4>(b.quaternion) = q.segment<4>(b.quaternion);
    Vector3d w = next.v.segment<3>(3 * b.spin);
    rotate_freely(b.moments, dt, w, next.q.data() + b.quaternion);
    for (int c = 0; c < 3; ++c)
      if (s.free[b.spin] >> c & 1) next.v[3 * b.spin + c] = w[c];
  }
}

Status Leapfrog::step(double dt, State& state, History& history, EnergyLedger* ledger) {
  const System& s = *system_;
  const auto W = s.inverse_mass.array();
  const Kernels& kernel = kernels();
  const std::size_t n = static_cast<std::size_t>(state.v.size());
  const double half = 0.5 * dt;
  next_.q.resize(state.q.size());
  next_.v.resize(state.v.size());
  v_next_.resize(state.v.size());
  if (history.force.size() != state.v.size()) {
    if (Status status = evaluate_forces(s, state, history.force); !status.ok()) {
      history.force.resize(0);
      return status;
    }
    ++counts_.force_evaluations;
  }

  // first kick and drift
  next_.t = state.t + dt;
  kernel.kick(n, half, s.inverse_mass.data(), history.force.data(), state.v.data(), next_.v.data());
  VectorXd kicked = ledger ? next_.v : VectorXd();
  if (s.has_hard_rows) {
    VectorXd w = next_.v;
    if (Status status = drift_on_rows(dt, state.q, w, next_); !status.ok()) return status;
    if (ledger) kicked = w;
  } else {
    drift(dt, state.q, next_);
  }
  drive(s, next_);

  // second kick
  const bool damped = s.has_damping || s.forces.has_drag;
  if (Status status = evaluate_undamped_forces(s, next_, force_); !status.ok()) return status;
  ++counts_.steps, ++counts_.force_evaluations;
  if (matrix_) {
    if (Status status = solve_kick(dt, next_, v_next_); !status.ok()) return status;
  } else if (damped) {
    v_next_ = (next_.v.array() + half * W * force_.array()) / (1.0 + half * W * s.forces.drag.array());
  } else {
    kernel.kick(n, half, s.inverse_mass.data(), force_.data(), next_.v.data(), v_next_.data());
  }
  // what this kick used: F(q', v'), and with hard rows their force too, which the next first kick must not
  // repeat
  const bool own = damped || s.has_hard_rows;
  VectorXd used;
  if (own) used = s.inertia.cwiseProduct(v_next_ - next_.v) / half;
  if (s.has_hard_rows && damped) {
    State end = next_;
    end.v = v_next_;
    if (Status status = evaluate_forces(s, end, force_); !status.ok()) return status;
    ++counts_.force_evaluations;
  } else if (damped) {
    force_ = used;
  }

  ImpulseLedger record(s, state, ledger);
  if (ledger) {
    const VectorXd first =
        s.has_hard_rows ? VectorXd(s.inertia.cwiseProduct(kicked - state.v) / half) : history.force;
    record.kick(half, state, first, state.v, kicked);
    if (!s.bodies.empty())
      ledger->numerical = kinetic_energy_change(s, kicked, next_.v);  // of the free rotation
    State end = next_;
    end.v = v_next_;
    record.kick(half, end, own ? used : force_, next_.v, v_next_);
  }
  std::swap(next_.v, v_next_);
  std::swap(state, next_);
  std::swap(history.force, force_);
  record.close(state);
  return {};
}

}  // namespace feder
