// Leapfrog with velocity-implicit second kick. History::force holds F(q, v) of the last step's end: the next
// first kick needs no new evaluation. With C = B + J^T b J the second kick is (M + dt/2 C) v' = M v+ + dt/2
// F0(q'), F0 without damping.
#include "solvers/leapfrog.h"

#include "solvers/impulse_ledger.h"

namespace feder {

Leapfrog::Leapfrog(const System& system, const IntegratorOptions& options)
    : system_(&system), options_(options) {}

Status Leapfrog::prepare() {
  damping_.reset();
  if (!system_->has_damping) return {};
  damping_ = std::make_unique<Damping>(Damping{{}, LinearSolver(options_.route, options_.solve), {}});
  damping_->kkt.prepare(*system_);
  return damping_->solver.analyze(*system_, false);
}

Status Leapfrog::damped_kick(double dt, const State& half, VectorXd& v_next) {
  Kkt& kkt = damping_->kkt;
  kkt.set_step(0.0, 0.5 * dt);
  if (Status status = kkt.evaluate(half.q, false); !status.ok()) return status;
  kkt.p.array() = system_->inertia.array() * half.v.array() + 0.5 * dt * force_.array();
  for (int i : system_->masked) kkt.p[i] = 0.0;
  kkt.r.setZero();
  if (Status status = damping_->solver.factor(kkt); !status.ok()) return status;
  return damping_->solver.solve(kkt, v_next, damping_->y).status;
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
  kernel.kick(n, half, s.inverse_mass.data(), history.force.data(), state.v.data(), next_.v.data());
  const VectorXd kicked = ledger ? next_.v : VectorXd();
  drift(dt, state.q, next_);
  next_.t = state.t + dt;

  // second kick
  const bool damped = s.has_damping || s.forces.has_drag;
  if (Status status = evaluate_undamped_forces(s, next_, force_); !status.ok()) return status;
  ++counts_.steps, ++counts_.force_evaluations;
  if (s.has_damping) {
    if (Status status = damped_kick(dt, next_, v_next_); !status.ok()) return status;
  } else if (damped) {
    v_next_ = (next_.v.array() + half * W * force_.array()) / (1.0 + half * W * s.forces.drag.array());
  } else {
    kernel.kick(n, half, s.inverse_mass.data(), force_.data(), next_.v.data(), v_next_.data());
  }
  if (damped) force_ = s.inertia.cwiseProduct(v_next_ - next_.v) / half;  // the damped force this kick used

  ImpulseLedger record(s, state, ledger);
  if (ledger) {
    record.kick(half, state, history.force, state.v, kicked);
    if (!s.bodies.empty())
      ledger->numerical = kinetic_energy_change(s, kicked, next_.v);  // of the free rotation
    State end = next_;
    end.v = v_next_;
    record.kick(half, end, force_, next_.v, v_next_);
  }
  std::swap(next_.v, v_next_);
  std::swap(state, next_);
  std::swap(history.force, force_);
  record.close(state);
  return {};
}

}  // namespace feder
