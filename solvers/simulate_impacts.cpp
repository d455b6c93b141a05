// Event location. With g(h) the smallest gap after a step of length h, an impact lies in a step where g
// changes its sign; Illinois' regula falsi finds it, every evaluation one step from the saved state, so that
// the located state is one the integrator made.
#include "solvers/simulate_impacts.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "engine/check.h"
#include "engine/energy.h"
#include "solvers/contact/impacts.h"
#include "solvers/simulate.h"

namespace feder {
namespace {

constexpr int kMostRoots = 100;

// What an impact needs beyond the integrator.
class Events {
 public:
  Events(const System& system, const System& smooth, Integrator& integrator, const ImpactOptions& options)
      : system_(system),
        smooth_(smooth),
        integrator_(integrator),
        options_(options),
        finder_(system),
        response_(system) {}

  double tolerance(const State& state) const {
    return options_.gap_tolerance * (1.0 + state.q.head(3 * system_.places()).lpNorm<Eigen::Infinity>());
  }
  double gap(const State& state) { return finder_.smallest_gap(state, kMargin); }
  Status step(double h, State& state, History& history) {
    return std::visit([&](auto& i) { return i.step(h, state, history, nullptr); }, integrator_);
  }
  Status locate(double dt, const State& from, const History& past, State& state, History& history);
  Status jump(State& state, History& history, Impact& impact);

 private:
  const System &system_, &smooth_;
  Integrator& integrator_;
  const ImpactOptions& options_;
  ContactFinder finder_;
  ImpactResponse response_;
  static constexpr double kMargin = 1e-2;  // gaps beyond are not told apart [m]
};

// A step whose gap is closed to the tolerance: state and history become its end. Where the step starts
// touching (after an impact) only bisection can tell that root from the next one.
Status Events::locate(double dt, const State& from, const History& past, State& state, History& history) {
  const double tolerance = this->tolerance(from);
  double low = 0.0, high = dt, at_low = gap(from), at_high = gap(state);
  int side = 0;
  for (int i = 0; i < kMostRoots; ++i) {
    double h = 0.5 * (low + high);
    if (at_low > tolerance && i % 4 != 3) h = low + at_low * (high - low) / (at_low - at_high);
    if (!(h > low && h < high)) break;
    state = from, history = past;
    if (Status status = step(h, state, history); !status.ok()) return status;
    const double here = gap(state);
    if (std::abs(here) <= tolerance) break;
    const bool closed = here < 0.0;
    (closed ? high : low) = h;
    (closed ? at_high : at_low) = here;
    // the end that stays is given less weight (Illinois)
    if (side == (closed ? -1 : 1)) (closed ? at_low : at_high) *= 0.5;
    side = closed ? -1 : 1;
  }
  return {};
}

// Velocities jump at all contacts that are closed.
Status Events::jump(State& state, History& history, Impact& impact) {
  finder_.find(state, 0.0, impact.rows);
  const double closed = 4.0 * tolerance(state);
  impact.rows.keep_within(closed);
  impact.t = state.t;
  if (impact.rows.count() == 0)
    return Status::failure(StatusCode::kNotConverged, "an impact could not be located within its tolerance");
  VectorXd u;
  impact.rows.velocities(state.v, u);
  for (int i = 0; i < impact.rows.count(); ++i) impact.approach = std::max(impact.approach, -u[3 * i]);
  if (Status status = response_.at(state.q); !status.ok()) return status;
  const VectorXd before = state.v;
  const ImpactOutcome outcome = resolve_impacts(
      impact.rows, [&](const VectorXd& force, VectorXd& v) { response_(force, v); }, options_.rule, state.v);
  impact.impulse = outcome.impulse;
  impact.jammed = outcome.jammed;
  impact.energy_change = kinetic_energy_change(smooth_, before, state.v);
  history.force.resize(0);  // forces may look at velocities
  return outcome.status;
}

Status stays_closed(const Impact& impact) {
  char text[160];
  const Contact& contact = impact.rows.contacts.front();
  (void)std::snprintf(
      text, sizeof text,
      "colliders %d and %d stay closed from t = %.6g s (approach %.1e m/s): take an integrator "
      "with contacts in its step",
      contact.a, contact.b, impact.t, impact.approach);
  return Status::failure(StatusCode::kLimitReached, text);
}

}  // namespace

System without_colliders(const System& system) {
  System smooth = system;
  smooth.colliders.clear();
  smooth.contact_stencil.clear();
  return smooth;
}

ImpactRun simulate_impacts(const System& system, const std::string& name, const IntegratorOptions& how,
                           State& state, History& history, const ImpactOptions& options) {
  ImpactRun run;
  const std::int64_t count = step_count(state.t, options.end_time, options.dt);
  const System smooth = without_colliders(system);
  Integrator integrator = make_integrator(name, smooth, how);
  if (const std::string why = refusal(integrator, smooth); !why.empty()) {
    run.status = Status::failure(StatusCode::kRefused, why);
    return run;
  }
  run.status = std::visit([](auto& i) { return i.prepare(); }, integrator);
  if (!run.status.ok()) return run;
  Events events(system, smooth, integrator, options);
  const double t0 = state.t;
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };

  for (std::int64_t i = 1; i <= count && run.status.ok(); ++i) {
    const double target = i == count ? options.end_time : t0 + static_cast<double>(i) * options.dt;
    while (state.t < target && run.status.ok()) {
      const State from = state;
      const History past = history;
      const double h = target - state.t;
      run.status = events.step(h, state, history);
      ++run.steps;
      if (run.status.ok() && events.gap(state) < -events.tolerance(state)) {
        run.status = events.locate(h, from, past, state, history);
        Impact impact;
        if (run.status.ok()) run.status = events.jump(state, history, impact);
        if (run.status.ok() && !(impact.approach > options.least_approach)) run.status = stays_closed(impact);
        if (run.status.ok()) run.record.push_back(impact), ++run.impacts;
        if (run.status.ok() && run.impacts >= options.most_impacts)
          run.status = Status::failure(StatusCode::kLimitReached, "the most impacts allowed were met");
      } else if (run.status.ok()) {
        state.t = target;
      }
      if (!run.status.ok()) state = from, history = past;
      if (run.status.ok() && options.observer && !options.observer(state))
        run.status = Status::failure(StatusCode::kInterrupted, "stopped by the observer");
      if (run.status.ok() && options.max_seconds > 0.0 && seconds() > options.max_seconds)
        run.status = Status::failure(StatusCode::kLimitReached, "the wall-clock budget is used up");
    }
  }
  run.seconds = seconds();
  return run;
}

}  // namespace feder
