// Its ledger: dK = dt f.(v + v')/2 exactly, since v' - v = dt M^-1 f; what density rows add counts as row
// work.
#include "solvers/symplectic_euler.h"

#include "engine/fluid/density_rows.h"
#include "solvers/impulse_ledger.h"
#include "solvers/step_row_solver.h"

namespace feder {

struct SymplecticEuler::Projection {
  DensityRows density;
  StepRowSolver solver;
  VectorXd swept, y;
};

SymplecticEuler::SymplecticEuler(const System& system, const IntegratorOptions& options)
    : system_(&system), options_(options) {}
SymplecticEuler::SymplecticEuler(SymplecticEuler&&) noexcept = default;
SymplecticEuler& SymplecticEuler::operator=(SymplecticEuler&&) noexcept = default;
SymplecticEuler::~SymplecticEuler() = default;

Status SymplecticEuler::prepare() {
  projection_.reset();
  if (!(system_->fluid && system_->fluid->incompressible())) return {};
  const std::string& route = options_.route;
  if (route != "auto" && route != "dual" && route != "sweeps")
    return Status::failure(
        StatusCode::kRefused,
        "symplectic_euler: route " + route + " for an incompressible fluid, not auto, dual or sweeps");
  projection_ = std::make_unique<Projection>();
  return {};
}

// v' onto the density rows of the start, phi + dt phidot(v') <= 0. Multipliers start at 0, so that a step
// depends on its state alone.
Status SymplecticEuler::hold_density(double dt, const State& state) {
  constexpr double kLeft = 1e-9;      // of phi, at most
  constexpr double kSoftness = 1e-4;  // of a row's own mobility, in each round
  // sweeps that guess which rows push: more in space, where factors are dearer
  const int guess = system_->fluid->material().dimension > 2 ? 300 : 100;
  auto& [density, solver, swept, y] = *projection_;
  const VectorXd& W = system_->inverse_mass;
  if (!density.evaluate(*system_->fluid, state.q, dt))
    return Status::failure(StatusCode::kNonFinite, "a position of the fluid is not finite");
  y.setZero(density.rows.count());
  if (options_.route == "sweeps") {
    for (int i = 0; i < options_.sweeps; ++i)
      if (sweep_step_rows(density.rows, W, v_next_, y, options_.row_weights) == 0.0) break;
    return {};
  }
  swept = v_next_;
  for (int i = 0; i < guess; ++i)
    if (sweep_step_rows(density.rows, W, swept, y) == 0.0) break;
  for (int k = 0; k < density.rows.count(); ++k)
    density.rows.gamma[k] = kSoftness * density.rows.mobility(k, W);
  return solver.close(density.rows, W, kLeft / dt, v_next_, y);
}

Status SymplecticEuler::step(double dt, State& state, History& history, EnergyLedger* ledger) {
  const System& s = *system_;
  if (Status status = evaluate_forces(s, state, force_); !status.ok()) return status;
  add_gyroscopic_torques(s, state.v, force_);
  ++counts_.steps, ++counts_.force_evaluations;
  // v' = v + dt M^-1 F
  v_next_ = state.v + dt * s.inverse_mass.cwiseProduct(force_);
  if (projection_) {
    if (Status status = hold_density(dt, state); !status.ok()) return status;
    force_ = s.inertia.cwiseProduct(v_next_ - state.v) / dt;
  }
  ImpulseLedger record(s, state, ledger);
  if (ledger) record.kick(dt, state, force_, state.v, v_next_);
  // q' = q + dt v'
  advance(s, dt, v_next_, state.q, state.q, options_.rotation_update);
  state.v.swap(v_next_);
  state.t += dt;
  drive(s, state);
  history.force.resize(0);
  record.close(state);
  return {};
}

}  // namespace feder
