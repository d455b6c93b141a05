// Stages k_i = (v_i, M^-1 f_i) at (q, v) + a_i dt k_(i-1), a = 0, 1/2, 1/2, 1; weights 1/6, 1/3, 1/3, 1/6.
// Quaternions are numbers like others (stages off the unit sphere by O(dt^2)) until the step is complete;
// only then normalised. Its ledger: v' - v = sum_i b_i dt M^-1 f_i is a sum of kicks, each with the mean
// velocity (v + v')/2 of the whole step.
#include "solvers/rk4.h"

#include "solvers/impulse_ledger.h"

namespace feder {
namespace {
constexpr double kNode[4] = {0.0, 0.5, 0.5, 1.0};
constexpr double kWeight[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
}  // namespace

void Rk4::drive(State& at) const {
  if (!system_->driven()) return;
  place_driven_nodes(*system_, at.t, at.q);
  set_driven_velocities(*system_, at.t, at.v);
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
      drive(stage_);
    }
    if (Status status = evaluate_forces(s, stage_, force_[i]); !status.ok()) return status;
    add_gyroscopic_torques(s, stage_.v, force_[i]);
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
  drive(stage_);
  if (ledger)
    for (int i = 0; i < 4; ++i) record.kick(kWeight[i] * dt, stages[i], force_[i], state.v, stage_.v);
  std::swap(state, stage_);
  history.force.resize(0);
  record.close(state);
  return {};
}

}  // namespace feder
