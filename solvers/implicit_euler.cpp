// Linearised implicit Euler. Ledger: M(v' - v) = dt f - dt B v' - dt^2 Kg v' + J^T y, multiplied by v'.
#include "solvers/implicit_euler.h"

#include <algorithm>
#include <cmath>

#include "solvers/stopwatch.h"

namespace feder {

template <GeometricStiffness kKind>
Status LinearImplicitEuler<kKind>::prepare() {
  kkt_.prepare(*system_);
  dt_ = 0.0;
  if (!system_->colliders.empty()) contacts_.emplace(*system_);
  // particles on obstacles act inside their nodes' blocks of Mt
  const std::vector<int>& held = system_->contact_stencil;
  const bool blocks = std::any_of(held.begin(), held.end(), [](int stencil) { return stencil >= 0; });
  return solver_.analyze(*system_, kGeometric || blocks);
}

template <GeometricStiffness kKind>
void LinearImplicitEuler<kKind>::reset_times() {
  times_ = {};
  solver_.reset_times();
}

template <GeometricStiffness kKind>
Status LinearImplicitEuler<kKind>::linearise(double dt, const State& state, const History& history) {
  const System& s = *system_;
  const bool stated = s.forces_look_at_state();
  if (stated) {  // forces that look at the state: at t_next, q_n, v_n
    at_ = state;
    at_.t += dt;
    evaluate_external_forces(s, at_, kkt_.p);
  }
  const VectorXd& force = stated ? kkt_.p : s.forces.constant;
  kernels().momentum(kkt_.p.size(), s.mass.data(), state.v.data(), dt, force.data(), kkt_.p.data());
  if (!s.bodies.empty()) {  // spins have no mass of their own: p = I w*
    v_start_ = state.v;
    if (!step_gyroscopic_terms(s, dt, v_start_))
      return Status::failure(StatusCode::kNotConverged, "the implicit gyroscopic step does not converge");
    for (const Body& b : s.bodies)
      kkt_.p.segment<3>(3 * b.spin) += b.moments.cwiseProduct(Vector3d(v_start_.segment<3>(3 * b.spin)));
    for (int i : s.masked) kkt_.p[i] = 0.0;
  }
  kkt_.set_step(dt * dt, dt);
  const double closing = std::max(dt, history.last_dt);
  if (dt != dt_ || (s.has_hard_rows && closing != closing_)) {
    memory_.resize(s.rows);
    for (int k = 0; k < s.rows; ++k) memory_[k] = s.memory(k, dt);
    rate_ = (1.0 - memory_.array()) / dt;
    for (int k = 0; k < s.rows && s.has_hard_rows; ++k)
      if (kkt_.gamma[k] == 0.0) rate_[k] *= dt / closing;
  }
  dt_ = dt, closing_ = closing;
  if (s.driven()) {  // driven nodes are where they will be: r = (phi - memory phi_n) / dt
    evaluate_phi(s, state.q, kkt_.r);
    at_.q = state.q;
    place_driven_nodes(s, state.t + dt, at_.q);
    if (Status status = kkt_.evaluate(at_.q, kGeometric); !status.ok()) return status;
    // of hard rows only phi_n is a gap to close; what their targets move is followed at once
    for (int k = 0; k < s.rows; ++k) {
      const double before = kkt_.r[k], moved = (kkt_.phi[k] - before) / dt;
      kkt_.r[k] = kkt_.gamma[k] == 0.0 ? rate_[k] * before + moved : (kkt_.phi[k] - memory_[k] * before) / dt;
    }
    for (int k : kkt_.dropped()) kkt_.r[k] = 0.0;
  } else {
    if (Status status = kkt_.evaluate(state.q, kGeometric); !status.ok()) return status;
    kernels().product(kkt_.r.size(), kkt_.phi.data(), rate_.data(), kkt_.r.data());
  }
  if constexpr (kGeometric) {
    // lambda at q_n from the last step: -d phi would carry what that step's linearisation left of phi, times
    // d, and a stiff spring would never become a rod
    lambda_ = history.lambda;
    if (lambda_.size() != s.rows) {
      lambda_.setZero(s.rows);
      for (int k = 0; k < s.rows; ++k)
        if (std::isfinite(s.stiffness[k])) lambda_[k] = -s.stiffness[k] * kkt_.phi[k];
    }
    at_ = state;
    at_.t += dt;
    place_driven_nodes(s, at_.t, at_.q);
    kkt_.set_geometric_stiffness(kKind, dt * dt, at_, lambda_);
  }
  return {};
}

template <GeometricStiffness kKind>
Status LinearImplicitEuler<kKind>::step(double dt, State& state, History& history, EnergyLedger* ledger) {
  const System& s = *system_;
  {
    const Stopwatch watch(times_.evaluate);
    if (Status status = linearise(dt, state, history); !status.ok()) return status;
  }
  if (contacts_) {
    const Status status = contacts_->solve(dt, state, history, kkt_, solver_, v_, y_, report_);
    if (!status.ok()) return status;
  } else {
    if (Status status = solver_.factor(kkt_); !status.ok()) return status;
    report_ = solver_.solve(kkt_, v_, y_);
    if (!report_.status.ok()) return report_.status;
  }
  ++counts_.steps, ++counts_.force_evaluations;

  if (ledger) {
    const VectorXd& start = s.bodies.empty() ? state.v : v_start_;  // after the gyroscopic step
    const VectorXd drag = -s.forces.drag.cwiseProduct(v_), dv = v_ - start, gyroscopic = start - state.v;
    const VectorXd impulse = (contacts_ ? contacts_->momentum() : kkt_.p) - s.inertia.cwiseProduct(start);
    const double pushed = contacts_ ? contacts_->work(v_) : 0.0,
                 blocks = contacts_ ? contacts_->block_work(v_) : 0.0;  // part of Mt, and of pushed
    VectorXd Jv, Kv = VectorXd::Zero(v_.size());
    kkt_.multiply_jacobian(v_, Jv);
    kkt_.add_geometric(v_, Kv);
    *ledger = {
        kinetic_energy_change(s, state.v, v_),
        -row_energy(s, state),
        impulse.dot(v_),
        dt * drag.dot(v_),
        y_.dot(Jv),
        blocks - Kv.dot(v_),
        -0.5 * (s.inertia.cwiseProduct(dv).dot(dv) + s.inertia.cwiseProduct(gyroscopic).dot(gyroscopic)),
        pushed};
  }
  {
    const Stopwatch watch(times_.update);
    advance(s, dt, contacts_ ? contacts_->place_velocity(v_) : v_, state.q, state.q, rotation_update_);
    std::swap(state.v, v_);
    state.t += dt;
    drive(s, state);
    if (s.has_hard_rows || kGeometric) history.lambda = y_ / dt;
    history.force.resize(0);
    history.last_dt = dt;
    if (contacts_) contacts_->remember(history);
  }
  if (ledger) ledger->row_change += row_energy(s, state);
  return {};
}

template class LinearImplicitEuler<GeometricStiffness::kOff>;
template class LinearImplicitEuler<GeometricStiffness::kClamped>;

}  // namespace feder
