#include "solvers/simulate.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>

#include "engine/check.h"

namespace feder {
namespace {

constexpr int kCheckEvery = 8;  // steps between two looks at the energy

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::string shown(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

Status refuse_or_prepare(const System& system, Integrator& integrator) {
  if (const std::string why = refusal(integrator, system); !why.empty())
    return Status::failure(StatusCode::kRefused, why);
  return std::visit([](auto& i) { return i.prepare(); }, integrator);
}

// Found before the step, or the bad number would show in some state after it only.
Status finite_motions(const System& system, double t) {
  for (const Drive& drive : system.drives)
    if (!drive.motion.position(t).allFinite() || !drive.motion.velocity(t).allFinite())
      return Status::failure(StatusCode::kNonFinite, "the motion of node " + std::to_string(drive.node) +
                                                         " is not finite at t = " + shown(t) + " s");
  return {};
}

template <class T>
void run(const System& system, T& integrator, State& state, History& history, const RunOptions& options,
         RunResult& result) {
  const double t0 = state.t, end = options.end_time;
  const std::int64_t steps = step_count(t0, end, options.dt);
  std::optional<DivergenceCheck> own;
  if (!options.check) own.emplace(system, state, end - t0, options.divergence);
  DivergenceCheck& check = options.check ? *options.check : *own;
  const auto start = std::chrono::steady_clock::now();
  for (std::int64_t n = 0; n < steps && result.status.ok(); ++n) {
    const bool last = n + 1 == steps;
    const double rest = end - state.t;
    // keep dt itself where the rest differs from it by rounding only: the step matrix stays the same
    const bool full = std::abs(rest - options.dt) <= step_rounding(t0, end, options.dt) * options.dt;
    const double dt = last && !full ? rest : options.dt;
    EnergyLedger* ledger = nullptr;
    if (options.ledgers) ledger = &options.ledgers->emplace_back();
    const double t = last ? end : std::fma(static_cast<double>(n + 1), options.dt, t0);
    result.status = finite_motions(system, t);
    if (result.status.ok()) result.status = integrator.step(dt, state, history, ledger);
    if (!result.status.ok()) break;
    state.t = t;
    result.steps = n + 1;
    if (last || n % kCheckEvery == kCheckEvery - 1) result.status = check(state);
    if (result.status.ok() && !last && options.max_seconds > 0.0 &&
        seconds_since(start) > options.max_seconds)
      result.status = Status::failure(StatusCode::kLimitReached,
                                      "wall-clock budget used up at t = " + shown(state.t) + " s");
    if (options.observer && result.status.ok() && !options.observer(state, history))
      result.status = Status::failure(StatusCode::kInterrupted, "stopped by the observer");
  }
  result.seconds = seconds_since(start);
}

}  // namespace

DivergenceCheck::DivergenceCheck(const System& s, const State& start, double span, double factor)
    : system_(s), start_(start.q), factor_(factor) {
  Eigen::Map<const Eigen::Matrix3Xd> x(start.q.data(), 3, s.places());
  const double size = (x.rowwise().maxCoeff() - x.rowwise().minCoeff()).norm();
  scale_ = kinetic_energy(s, start) + row_energy(s, start) + s.mass.sum() * size * size / (span * span);
}

Status DivergenceCheck::operator()(const State& state) {
  const double kinetic = kinetic_energy(system_, state);
  if (!std::isfinite(kinetic) || !state.q.allFinite())
    return Status::failure(StatusCode::kNonFinite, "state is not finite at t = " + shown(state.t) + " s");
  if (kinetic <= factor_ * scale_) return {};
  evaluate_external_forces(system_, state, force_);
  const double limit = factor_ * (scale_ + force_.norm() * (state.q - start_).norm());
  if (!(kinetic > limit)) return {};
  return Status::failure(StatusCode::kDiverged, "kinetic energy " + shown(kinetic) + " J passed " +
                                                    shown(limit) + " J at t = " + shown(state.t) + " s");
}

std::int64_t step_count(double t0, double end, double dt) {
  require_positive("run", "dt", dt, "s");
  require_finite("run", "start time", t0, "s");
  require_finite("run", "end time", end, "s");
  const double span = end - t0;
  if (!(span > 0.0)) fail_input("run", "end time", end, "s", "a time after the start, " + shown(t0) + " s");
  if (dt > span * (1.0 + 1e-9))
    fail_input("run", "dt", dt, "s", "at most the length of the run, " + shown(span) + " s");
  const double ratio = span / dt;
  if (!(ratio < 9007199254740992.0) || !(t0 + dt > t0) || !(end - dt < end))
    fail_input("run", "dt", dt, "s", "a step that the clock can resolve and fewer than 2^53 of them");
  return std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(ratio - step_rounding(t0, end, dt))));
}

double step_rounding(double t0, double end, double dt) {
  constexpr double kUlp = 2.3e-16, kMost = 1e-3;
  return std::min(kMost, 1e-9 + kUlp * std::max(std::abs(t0), std::abs(end)) / dt);
}

double equal_step(double t0, double end, double dt) {
  const double span = end - t0, ratio = span / dt, rounding = step_rounding(t0, end, dt);
  const double steps = std::max(1.0, std::ceil(ratio - rounding));
  return std::abs(ratio - steps) <= rounding ? std::min(dt, span) : span / steps;
}

RunResult simulate(const System& system, Integrator& integrator, State& state, History& history,
                   const RunOptions& options) {
  RunResult result;
  (void)step_count(state.t, options.end_time, options.dt);
  if (options.prepare) result.status = refuse_or_prepare(system, integrator);
  if (!result.status.ok()) return result;
  std::visit([&](auto& i) { run(system, i, state, history, options, result); }, integrator);
  return result;
}

double rotation_error(const System& s, const VectorXd& q_a, const VectorXd& q_b) {
  double sum = 0.0;
  for (const Body& b : s.bodies) {
    const Matrix3d R =
        rotation_matrix(q_a.data() + b.quaternion).transpose() * rotation_matrix(q_b.data() + b.quaternion);
    const Vector3d axis =
        0.5 * Vector3d(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));  // sin(theta)
    const double sine = axis.norm(), angle = std::atan2(sine, 0.5 * (R.trace() - 1.0));
    const Vector3d theta = sine > 1e-8 ? Vector3d(angle / sine * axis) : axis;
    // half a turn apart the axis is lost: any axis is wrong by that much
    sum += sine <= 1e-8 && angle > 1.0 ? angle * angle * b.moments.maxCoeff()
                                       : theta.dot(b.moments.cwiseProduct(theta));
  }
  return sum;
}

double doubling_error(const System& s, const State& full, const State& halves, double dt, int order) {
  double sum = 0.0;
  for (int i = 0; i < s.places(); ++i)
    if (s.free[i])
      sum += s.mass[i] * ((halves.q.segment<3>(3 * i) - full.q.segment<3>(3 * i)).squaredNorm() +
                          dt * dt * (halves.v.segment<3>(3 * i) - full.v.segment<3>(3 * i)).squaredNorm());
  sum += rotation_error(s, full.q, halves.q);
  for (const Body& b : s.bodies) {
    const Vector3d dw = halves.v.segment<3>(3 * b.spin) - full.v.segment<3>(3 * b.spin);
    sum += dt * dt * dw.dot(b.moments.cwiseProduct(dw));
  }
  double mass = 0.0;
  for (int i = 0; i < s.nodes; ++i)
    if (s.free[i]) mass += s.mass[i];
  for (const Body& b : s.bodies)
    if (!s.free[b.centre] && s.free[b.spin]) mass += s.mass[b.centre];  // it only turns
  return std::sqrt(sum / mass) / (std::ldexp(1.0, order) - 1.0);
}

namespace {

// Bad numbers stay bad numbers however short the step is.
Status too_small(double dt, double t, const Status& last) {
  const StatusCode code =
      last.code == StatusCode::kNonFinite ? StatusCode::kNonFinite : StatusCode::kStepTooSmall;
  return Status::failure(code, "step-size control asks for dt = " + shown(dt) + " s at t = " + shown(t) +
                                   " s" + (last.ok() ? "" : ": " + last.reason));
}

}  // namespace

AdaptiveResult simulate_adaptive(const System& system, Integrator& integrator, State& state, History& history,
                                 const AdaptiveOptions& options) {
  require_positive("adaptive run", "tolerance", options.tolerance, "m");
  require_positive("adaptive run", "first dt", options.first_dt, "s");
  if (!(options.end_time > state.t))
    fail_input("adaptive run", "end time", options.end_time, "s", "a time after the start");
  AdaptiveResult result;
  const bool extrapolate =
      options.extrapolate && !info(integrator).symmetric && system.bodies.empty();  // rotations do not add
  if (extrapolate && (system.has_hard_rows || !system.colliders.empty()))
    result.status = Status::failure(StatusCode::kRefused,
                                    "extrapolation would violate hard rows and contacts: switch it off");
  else
    result.status = refuse_or_prepare(system, integrator);
  if (!result.status.ok()) return result;

  const int order = info(integrator).order;
  const double gain = 1.0 / (std::ldexp(1.0, order) - 1.0);
  auto advance = [&](double dt, State& at, History& past) {
    return std::visit([&](auto& i) { return i.step(dt, at, past, nullptr); }, integrator);
  };
  const auto start = std::chrono::steady_clock::now();
  double dt = history.suggested_dt > 0.0 ? history.suggested_dt : options.first_dt;
  const double span = options.end_time - state.t;
  result.smallest_dt = span;
  State full, halves;
  History full_history, halves_history;
  while (state.t < options.end_time && result.status.ok()) {
    const bool last = dt >= (options.end_time - state.t) * (1.0 - 1e-12);
    const double h = last ? options.end_time - state.t : dt;
    full = halves = state;
    full_history = halves_history = history;

    // one full step against two half steps
    Status status = finite_motions(system, state.t + h);
    if (status.ok()) status = advance(h, full, full_history);
    if (status.ok()) status = advance(0.5 * h, halves, halves_history);
    if (status.ok()) status = advance(0.5 * h, halves, halves_history);
    double error = status.ok() ? doubling_error(system, full, halves, h, order) : HUGE_VAL;
    if (!std::isfinite(error)) error = HUGE_VAL;
    if (status.code == StatusCode::kRefused) result.status = status;

    // accept, and the next step: error per step falls with dt^(p+1), error per unit step with dt^p
    const double bound = extrapolate ? options.tolerance : options.tolerance * h / span;
    const double factor =
        error > 0.0 ? 0.9 * std::pow(bound / error, 1.0 / (extrapolate ? order + 1 : order)) : 5.0;
    if (error <= bound) {
      if (extrapolate) {
        halves.q += gain * (halves.q - full.q);
        halves.v += gain * (halves.v - full.v);
        halves_history.force.resize(0);
      }
      std::swap(state, halves);
      std::swap(history, halves_history);
      if (last) state.t = options.end_time;
      ++result.accepted;
      result.smallest_dt = std::min(result.smallest_dt, h);
      result.largest_dt = std::max(result.largest_dt, h);
      if (options.observer && !options.observer(state, h, error))
        result.status = Status::failure(StatusCode::kInterrupted, "stopped by the observer");
    } else {
      ++result.rejected;
    }
    dt = h * std::clamp(factor, 0.2, 5.0);
    if (!last || error > bound) history.suggested_dt = dt;
    if (dt < options.least_dt && state.t < options.end_time)
      result.status = too_small(dt, state.t, status);
    else if (result.accepted + result.rejected >= options.most_steps)
      result.status = Status::failure(StatusCode::kLimitReached, "step budget used up");
  }
  result.seconds = seconds_since(start);
  return result;
}

}  // namespace feder
