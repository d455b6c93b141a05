// Unknowns v' and y = dt lambda. With q' = q_n + dt v':
//   G = M (v' - v_n) + dt B v' - dt f_ext - J(q')^T y = 0
//   g = gamma y + (phi(q') - memory phi(q_n)) / dt = 0,  memory = b/(dt d + b), tau/(dt + tau) for hard rows
//   Newton: [Mt, -J^T; -J, -gamma] (dv, dy) = (-G, g),  Mt = M + dt B + dt^2 Kg(y/dt).  Phi's gradient is G.
// Far away soft rows take y from g = 0. Near the solution y is an unknown like v: taken from phi it would
// carry the rounding of q times the stiffness into the balance. So it is where a full step is cut: the
// valley of a stiff row bends, and cuts that stay in it number sqrt(d). Bodies: v_n is taken after the
// implicit gyroscopic step, q' = q_n exp(dt v'), J by v' (J_r of the turn), so that G is a gradient there,
// too; J_r w = w, so no work is changed. Ledger: M (v' - v_n) = dt f - dt B v' + J(q')^T y, multiplied by v';
// what is left of G shows as imbalance.
#include "solvers/implicit_euler_newton.h"

#include <cmath>
#include <cstdio>

namespace feder {
namespace {
constexpr double kArmijo = 1e-4;     // required fraction of the predicted decrease
constexpr double kRounding = 1e-13;  // changes of the merit below this fraction of its terms are noise
constexpr double kNear =
    1e-6;  // residual below which the merit is mostly rounding: the residual itself decides
constexpr double kStalledButGood =
    1e-9;  // residual at which a Newton that no longer contracts has reached rounding
constexpr double kRoundings = 4.0 * 2.2e-16;  // nothing can be solved below a few roundings of q
constexpr double kFlat =
    0.8;  // fraction of the linear decrease above which a full step is made longer; 0.5 is Newton's own
constexpr double kLongest = 1e6;
// gamma of redundant hard rows, as a fraction of their mobility.
constexpr double kLeastStabilised = 1e-10, kMostStabilised = 1e-3;
constexpr int kMostCuts = 30;
// With y an unknown: the fall of the residual that starts it far from the solution, rises it survives.
constexpr double kFalls = 0.5, kRise = 1e3;
constexpr int kMostRises = 4;
// Fraction of the negative part of Kg in the matrix: less after an indefinite matrix, more after a good one.
// On buckling cloth this needs half the factorisations of "all or nothing".
constexpr double kKeptShrinks = 0.5, kKeptGrows = 1.25;
constexpr double kLeastKept = 1.0 / 16.0;  // below: none

Status not_converged(double relative) {
  char text[96];
  std::snprintf(text, sizeof text, "Newton ran out of iterations at relative residual %.2g", relative);
  return Status::failure(StatusCode::kNotConverged, text);
}
}  // namespace

Status ImplicitEulerNewton::prepare() {
  kkt_.prepare(*system_);
  rank_known_ = redundant_ = false;
  return solver_.analyze(*system_, true);
}

Status ImplicitEulerNewton::evaluate(double dt, const State& start, Multipliers multipliers, Iterate& at) {
  const System& s = *system_;
  at.multipliers = multipliers;
  at.state.t = start.t + dt;
  advance(s, dt, at.state.v, start.q, at.state.q);
  place_driven_nodes(s, at.state.t, at.state.q);
  ++counts_.force_evaluations;
  if (Status status = kkt_.evaluate(at.state.q); !status.ok()) return status;
  kkt_.take_spins_over_a_step(dt, at.state.v);
  at.phi = kkt_.phi;

  // rows
  at.g = (at.phi - remembered_) / dt;
  if (multipliers == Multipliers::kOwn) at.g += kkt_.gamma.cwiseProduct(at.y);
  for (int k = 0; multipliers == Multipliers::kOfPhi && k < s.rows; ++k)
    if (kkt_.gamma[k] > 0.0) {
      at.y[k] = -at.g[k] * kkt_.inverse_gamma[k];
      at.g[k] = 0.0;
    }

  // momentum balance and its scale
  evaluate_external_forces(s, at.state, external_);
  VectorXd rows = VectorXd::Zero(at.state.v.size());
  kkt_.add_jacobian_transpose(at.y, rows);
  for (int i : s.masked) rows[i] = 0.0;
  at.residual = kkt_.mass.cwiseProduct(at.state.v) - s.inertia.cwiseProduct(v_start_) - dt * external_ - rows;
  for (int i : s.masked) at.residual[i] = 0.0;
  const double scale = kkt_.mass.cwiseProduct(at.state.v).norm() + s.inertia.cwiseProduct(v_start_).norm() +
                       dt * external_.norm() + rows.norm();
  const double row_scale = at.state.v.norm() + at.state.q.norm() / dt;
  at.relative = (scale > 0.0 ? at.residual.norm() / scale : 0.0) + at.g.norm() / row_scale;
  return std::isfinite(at.relative)
             ? Status{}
             : Status::failure(StatusCode::kNonFinite, "Newton residual is not finite");
}

Status ImplicitEulerNewton::factor_and_solve(const Iterate& at) {
  const System& s = *system_;
  kkt_.r = at.g;
  if (s.has_hard_rows && !rank_known_) {
    redundant_ = !hard_row_rank(kkt_).dependent.empty();
    rank_known_ = true;
  }
  VectorXd mobility;
  if (redundant_) {
    mobility = row_mobility(kkt_);
    const double epsilon = std::clamp(at.relative, kLeastStabilised, kMostStabilised);
    for (int k = 0; k < s.rows; ++k)
      if (std::isinf(s.stiffness[k])) kkt_.gamma[k] = epsilon * mobility[k];
  }
  Status status = solver_.factor(kkt_);
  if (status.ok()) status = solver_.solve(kkt_, dv_, dy_).status;
  for (int k = 0; k < s.rows && redundant_; ++k)
    if (std::isinf(s.stiffness[k])) kkt_.gamma[k] = 0.0;
  if (kkt_.dropped().empty()) return status;
  kkt_.drop_rows({});  // a configuration where they depend: from now on stabilised
  redundant_ = true;
  return factor_and_solve(at);
}

// Redundant rows that stay open when the iteration ends contradict each other.
Status ImplicitEulerNewton::ended(const Status& failure) const {
  constexpr double kContradiction = 1e-6;
  int row = -1;
  for (int k = 0; k < system_->rows && redundant_; ++k)
    if (std::isinf(system_->stiffness[k]) && (row < 0 || std::abs(at_.g[k]) > std::abs(at_.g[row]))) row = k;
  const double size = at_.state.q.head(3 * system_->places()).lpNorm<Eigen::Infinity>();
  const double gap = row < 0 ? 0.0 : std::abs(at_.phi[row]);
  if (!(gap > kContradiction * size)) return failure;
  char text[96];
  std::snprintf(text, sizeof text, " contradicts rows it depends on: %.2g m or rad stay open (", gap);
  return Status::failure(StatusCode::kInconsistent, system_->row_name(row) + text + failure.reason + ")");
}

Status ImplicitEulerNewton::solve_direction(double dt, const Iterate& at) {
  lambda_ = at.y / dt;
  kkt_.p = -at.residual;
  for (;;) {
    const GeometricStiffness kind = kept_ == 1.0 ? GeometricStiffness::kFull : GeometricStiffness::kClamped;
    kkt_.set_geometric_stiffness(kind, dt * dt, at.state, lambda_, kept_, dt);
    const Status status = factor_and_solve(at);
    if (status.ok()) kept_ = std::min(1.0, kKeptGrows * std::max(kept_, kLeastKept));
    if (status.code != StatusCode::kSingular || kept_ == 0.0) return status;
    ++counts_.indefinite_matrices;
    kept_ = kept_ > kLeastKept ? kKeptShrinks * kept_ : 0.0;
  }
}

// Forces without an energy have their slope at the iterate only: no reason to go far along it.
bool ImplicitEulerNewton::frozen() const {
  return !system_->law_springs.empty() || system_->fluid ||
         (system_->forces.user && !system_->forces.user.potential);
}

double ImplicitEulerNewton::merit(double dt, const Iterate& at, double& magnitude) const {
  const System& s = *system_;
  const auto v = at.state.v.array();
  const double inertia = 0.5 * (s.inertia.array() * (v - v_start_.array()).square()).sum();
  const double drag = 0.5 * dt * (s.forces.drag.array() * v.square()).sum();
  double rows = 0.0, penalty = 0.0;
  for (int k = 0; k < s.rows; ++k) {
    const double phi = at.phi[k];
    if (kkt_.gamma[k] == 0.0)
      penalty += penalty_ * std::abs(phi - remembered_[k]);
    else if (kkt_.inverse_gamma[k] > 0.0)
      rows += kkt_.inverse_gamma[k] / (dt * dt) * (0.5 * phi * phi - remembered_[k] * phi);
  }
  // law springs, a fluid and a user force without a potential are frozen at the current iterate: the slope
  // there is still right
  const double external = s.forces.user && !frozen() ? s.forces.user.potential(at.state.t, at.state.q) -
                                                           dt * s.forces.constant.dot(at.state.v)
                                                     : -dt * frozen_force_.dot(at.state.v);
  magnitude = inertia + drag + std::abs(rows) + penalty + std::abs(external);
  return inertia + drag + rows + penalty + external;
}

// A full step of v and y, taken if the residual falls below the bound.
Status ImplicitEulerNewton::try_full_step(double dt, const State& start, double bound, Iterate& at,
                                          bool& taken) {
  trial_.state.v = at.state.v + dv_;
  trial_.y = at.y + dy_;
  Status status = evaluate(dt, start, Multipliers::kOwn, trial_);
  taken = status.ok() && trial_.relative < bound;
  if (!taken) return status;
  if (trial_.relative >= at.relative) ++rises_;
  std::swap(at, trial_);
  return status;
}

// Far from the solution with y an unknown. Where the residual does not fall, back to where that began.
Status ImplicitEulerNewton::go_on_with_own(double dt, const State& start, Iterate& at, bool& taken) {
  const double patience = rises_ < kMostRises ? kRise : 1.0;
  if (try_full_step(dt, start, patience * at.relative, at, taken).ok() && taken) return {};
  own_allowed_ = false;
  taken = true;
  at.state.v = v_before_own_;
  at.y = y_before_own_;
  return evaluate(dt, start, Multipliers::kOfPhi, at);
}

Status ImplicitEulerNewton::line_search(double dt, const State& start, Iterate& at) {
  bool taken = false;
  if (at.relative > kNear && !redundant_ && own_allowed_ && at.multipliers == Multipliers::kOwn)
    if (Status status = go_on_with_own(dt, start, at, taken); !status.ok() || taken) return status;
  // redundant rows: the stabilised step leaves a little of them open, which the penalty below does not
  // forgive
  if (at.relative <= kNear || redundant_) {
    const bool patient = at.relative > kStalledButGood && rises_ < kMostRises && !redundant_;
    const double bound = patient ? kRise * at.relative : at.relative;
    if (patient && rises_ == 0) v_before_own_ = at.state.v, y_before_own_ = at.y;
    if (Status status = try_full_step(dt, start, bound, at, taken); !status.ok() || taken) return status;
  }
  if (at.relative <= kNear) {
    // no better: stay, with the rows as they are there
    const bool stay = at.relative <= kStalledButGood || system_->has_hard_rows;
    if (Status status = evaluate(dt, start, stay ? at.multipliers : Multipliers::kOfPhi, at);
        !status.ok() || stay)
      return status;
  }
  // slope of Phi + penalty along (dv, dy): G.dv on soft rows; the penalty falls by its linearised violation
  frozen_force_ = external_;
  double slope = at.residual.dot(dv_), hard = 0.0, largest = 0.0;
  VectorXd Jdv;
  kkt_.multiply_jacobian(dv_, Jdv);
  for (int k = 0; k < system_->rows; ++k)
    if (kkt_.gamma[k] == 0.0) {
      largest = std::max(largest, std::abs(at.y[k] + dy_[k]) / dt);
      slope += at.y[k] * Jdv[k];  // Phi itself does not contain the hard rows' force
      hard += std::abs(at.g[k]) * dt;
    }
  penalty_ = std::max(penalty_, 2.0 * largest);
  slope -= penalty_ * hard;

  double magnitude = 0.0, trial_magnitude = 0.0;
  const double before = merit(dt, at, magnitude);
  double step = 1.0;
  Status status;
  for (int cut = 0; cut <= kMostCuts; ++cut, step *= 0.5) {
    trial_.state.v = at.state.v + step * dv_;
    trial_.y = at.y + step * dy_;
    status = evaluate(dt, start, Multipliers::kOfPhi, trial_);
    if (status.ok()) {
      const double after = merit(dt, trial_, trial_magnitude);
      // rounding of q moves W by lambda dphi
      const double noise =
          kRounding * (magnitude + trial_magnitude) +
          kRoundings * at.state.q.lpNorm<Eigen::Infinity>() * (at.y.lpNorm<1>() + trial_.y.lpNorm<1>()) / dt;
      if (after <= before + kArmijo * step * slope + noise) {
        std::swap(at, trial_);
        return cut == 0 && !frozen() ? lengthen(dt, start, before, slope, at) : Status{};
      }
    }
    if (cut == 0 && own_allowed_ && !redundant_) {
      v_before_own_ = at.state.v, y_before_own_ = at.y;
      if (try_full_step(dt, start, kFalls * at.relative, at, taken).ok() && taken) return {};
    }
    ++counts_.line_search_cuts;
  }
  return Status::failure(StatusCode::kNotConverged,
                         "line search found no decrease of the incremental potential");
}

// Doubles a full step as long as the merit falls almost as the slope says: there the matrix overestimates the
// curvature (what was clamped, or a saddle near by), and short steps would creep.
Status ImplicitEulerNewton::lengthen(double dt, const State& start, double before, double slope,
                                     Iterate& at) {
  double magnitude = 0.0, reached = merit(dt, at, magnitude);
  if (!(reached <= before + kFlat * slope)) return {};
  const VectorXd v = at.state.v - dv_;
  for (double step = 2.0; step < kLongest; step *= 2.0) {
    trial_.state.v = v + step * dv_;
    trial_.y = at.y;
    const Status status = evaluate(dt, start, Multipliers::kOfPhi, trial_);
    const double after = status.ok() ? merit(dt, trial_, magnitude) : HUGE_VAL;
    if (!(after < reached)) return evaluate(dt, start, Multipliers::kOfPhi, at);
    std::swap(at, trial_);
    reached = after;
    if (!(after <= before + kFlat * step * slope)) return {};
  }
  return {};
}

Status ImplicitEulerNewton::step(double dt, State& state, History& history, EnergyLedger* ledger) {
  const System& s = *system_;
  kkt_.set_step(dt * dt, dt);
  evaluate_phi(s, state.q, remembered_);
  for (int k = 0; k < s.rows; ++k) remembered_[k] *= s.memory(k, dt);
  penalty_ = 0.0;
  kept_ = 1.0;
  own_allowed_ = true;
  rises_ = 0;
  v_start_ = state.v;
  if (!step_gyroscopic_terms(s, dt, v_start_))
    return Status::failure(StatusCode::kNotConverged, "the implicit gyroscopic step does not converge");

  // start from rest at q_n: the first iterate is the linearised step
  at_.state.v.setZero(state.v.size());
  at_.y = VectorXd::Zero(s.rows);
  if (s.has_hard_rows && history.lambda.size() == s.rows) at_.y = dt * history.lambda;
  if (Status status = evaluate(dt, state, Multipliers::kOfPhi, at_); !status.ok()) return status;
  bool converged = false;
  for (int i = 0; i < options_.most_newton_iterations && !converged; ++i) {
    const double before = at_.relative;
    if (Status status = solve_direction(dt, at_); !status.ok()) return status;
    if (Status status = line_search(dt, state, at_); !status.ok()) return ended(status);
    ++counts_.newton_iterations;
    // stalled at rounding: of the terms, or (near rest, where they all vanish) of q through the soft rows
    const double floor = kRoundings * at_.state.q.lpNorm<Eigen::Infinity>() / dt * kkt_.inverse_gamma.norm();
    const bool at_floor =
        at_.relative <= kStalledButGood || (at_.g.isZero(0.0) && at_.residual.norm() <= floor);
    converged = at_.relative <= options_.newton_tolerance || (at_floor && at_.relative > 0.25 * before);
  }
  if (!converged) return ended(not_converged(at_.relative));
  ++counts_.steps;
  if (ledger) keep_books(dt, state, at_, *ledger);
  std::swap(state, at_.state);
  set_driven_velocities(s, state.t, state.v);
  history.lambda = at_.y / dt;
  history.force.resize(0);
  return {};
}

void ImplicitEulerNewton::keep_books(double dt, const State& start, const Iterate& end,
                                     EnergyLedger& ledger) const {
  const System& s = *system_;
  const VectorXd &v = end.state.v, dv = v - v_start_, gyroscopic = v_start_ - start.v,
                 drag = -s.forces.drag.cwiseProduct(v);
  VectorXd Jv;
  kkt_.multiply_jacobian(v, Jv);
  ledger = {kinetic_energy_change(s, start.v, v),
            row_energy(s, end.state) - row_energy(s, start),
            dt * external_.dot(v),
            dt * drag.dot(v),
            end.y.dot(Jv),
            0.0,
            -0.5 * (s.inertia.cwiseProduct(dv).dot(dv) + s.inertia.cwiseProduct(gyroscopic).dot(gyroscopic))};
}

}  // namespace feder
