// Which method and step for a scene. The rules, and where their figures were measured:
//   1  100 or more dependent hard rows, or rank unknown: implicit_euler_newton. Net S3b: others stop
//   (README). 2  other hard rows: rk4 with projection. `mechanisms`: error 1e-6 ... 1e-4 of the scene at 0.03
//   ... 0.06
//      rad of its fastest turning per step, cheaper there than leapfrog and the implicit methods.
//   3  damped rows, user forces, springs with a law: rk4 (leapfrog then solves a system or is not
//   symplectic). 4  slow motion asks for shorter steps than stability does: rk4, 0.05 rad of it per step. 5
//   all others: leapfrog at 0.9 of its limit. `work_precision`: cheapest below 1e-3 of the scene's length. 6
//   rules 2 to 5 need over a million steps, or no frequency is known: implicit_euler_newton, 0.02 rad of
//      the slow motion per step. `work_precision`: 0.3 ... 1.5 % of the scene's length there (S1, S2, S4).
//   rk4 stays below 0.9 kRk4Radius / rate, rate = (c + sqrt(c^2 + 4 omega^2))/2 >= |s| of every root.
#include "experiments/support/recommend.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "solvers/stability.h"

namespace feder::experiments {
namespace {

constexpr int kManyDependent = 100;
constexpr double kPhaseRk4 = 0.05, kPhaseImplicit = 0.02;  // slow motion per step [rad]
constexpr double kBelowLimit = 0.9;
constexpr const char* kShortened = " Shortened to a hundredth of the run.";
constexpr double kMostSteps = 1e6, kFewestSteps = 100.0;

// What a step of an accurate run must resolve, and which figure that is.
struct Rate {
  double value = 0.0;  // [rad/s]
  std::string name;
};

void raise(Rate& rate, double value, const char* name) {
  if (value > rate.value) rate = {value, name};
}

Rate slow_motion(const Explanation& e) {
  Rate rate;
  raise(rate, e.smallest_frequency, "the slowest mode");
  raise(rate, e.turning_rate, "the fastest turning at the start");
  raise(rate, e.swing_rate, "a free swing of the smallest part");
  return rate;
}

// The scene as a whole: what an implicit method of first order can still show.
Rate whole_motion(const Explanation& e, const System& system) {
  Rate rate;
  raise(rate, e.smallest_frequency, "the slowest mode");
  raise(rate, e.turning_rate, "the fastest turning at the start");
  raise(rate, std::sqrt(system.forces.gravity.norm() / e.scene_length), "a fall through the scene's length");
  if (rate.value == 0.0) rate = {2.0 * std::numbers::pi / e.end_time, "one period in the run"};
  return rate;
}

double largest_rate(const Explanation& e) {
  const double c = e.largest_damping_rate, omega = e.largest_frequency;
  return 0.5 * (c + std::sqrt(c * c + 4.0 * omega * omega));
}

// `dt`, or a hundredth of the run where that is shorter: true then.
bool set_step(Recommendation& r, double dt, double end_time) {
  r.dt = std::min(dt, end_time / kFewestSteps);
  r.steps = std::ceil(end_time / r.dt - 1e-9);
  return r.dt < dt;
}

Recommendation implicit(const Explanation& e, const System& system, const std::string& because) {
  const Rate slow = whole_motion(e, system);
  Recommendation r{.integrator = "implicit_euler_newton", .why = {}, .not_known = {}};
  const bool shortened = set_step(r, kPhaseImplicit / slow.value, e.end_time);
  r.why = fmt::format(
      "{}. The step turns {} ({:.3g} rad/s) by {} rad: errors near 1 % of the scene's length, and faster "
      "motion is damped away.",
      because, slow.name, slow.value, kPhaseImplicit);
  if (shortened) r.why += kShortened;
  return r;
}

std::string reason_for_rk4(const Explanation& e, bool other_forces) {
  if (e.all_rows.hard > 0) return "Hard rows held by projection at order 4; ";
  if (e.all_rows.damped > 0) return "Damped rows, taken explicitly at order 4; ";
  if (other_forces) return "Forces beyond rows, order 4; ";
  if (e.largest_frequency > 0.0)
    return "The motion to be seen is about as fast as the springs, where order 4 pays; ";
  return "Smooth motion without springs, where order 4 pays; ";
}

std::string reason_for_step(const Explanation& e, const Rate& slow, bool finite_rows_decide) {
  if (finite_rows_decide)
    return fmt::format("the step is 0.9 of what the finite rows allow (rate {:.3g} 1/s).", largest_rate(e));
  if (slow.value > 0.0)
    return fmt::format("the step turns {} ({:.3g} rad/s) by {} rad.", slow.name, slow.value, kPhaseRk4);
  return "no rate is known.";
}

Recommendation explicit_method(const Explanation& e, const System& system) {
  const Rate slow = slow_motion(e);
  const double smooth = kPhaseRk4 / slow.value;
  const bool other_forces = system.forces.user || !system.law_springs.empty();
  const bool damped = e.all_rows.damped > 0;
  const double leapfrog_dt = kBelowLimit * 2.0 / e.largest_frequency;
  const double rk4_dt = kBelowLimit * kRk4Radius / largest_rate(e);
  const bool leapfrog = e.all_rows.hard == 0 && !damped && !other_forces && leapfrog_dt <= smooth;
  Recommendation r{.integrator = leapfrog ? "leapfrog" : "rk4", .why = {}, .not_known = {}};
  const bool shortened = set_step(r, leapfrog ? leapfrog_dt : std::min(smooth, rk4_dt), e.end_time);
  if (leapfrog)
    r.why =
        "Undamped springs and nothing hard: one force evaluation per step, symplectic, at 0.9 of the "
        "limit 2 / omega_max.";
  else
    r.why = reason_for_rk4(e, other_forces) + reason_for_step(e, slow, rk4_dt < smooth);
  if (shortened) r.why += kShortened;
  return r;
}

std::string not_known(const Explanation& e, const System& system) {
  std::string text = "Not known: rates reached later in the run";
  if (system.driven()) text += ", how fast driven parts will move";
  if (system.forces.user && !system.forces.user.stiffness) text += ", the stiffness of the user force";
  if (!system.law_springs.empty()) text += ", the damping of springs with a law";
  if (e.all_rows.hard > 0) text += ", poses where hard rows lose rank";
  return text + ", the error you accept; halve dt to see it.";
}

}  // namespace

Recommendation recommend(const Explanation& e, const System& system) {
  Recommendation r;
  if (e.unknowns == 0) {
    r.why = "Nothing can move.";
    return r;
  }
  const bool hard = e.all_rows.hard > 0;
  if (hard && e.rank < 0)
    r = implicit(e, system, "The rank of the hard rows is not known: only Newton takes any");
  else if (hard && e.dependent >= kManyDependent)
    r = implicit(e, system, fmt::format("{} dependent hard rows, where the other methods stop", e.dependent));
  else if (std::isnan(largest_rate(e)))
    r = implicit(e, system, "No frequency is known, so no explicit step is known to be stable");
  else
    r = explicit_method(e, system);
  if (r.steps > kMostSteps && r.integrator != "implicit_euler_newton")
    r = implicit(e, system,
                 fmt::format("{} would need {:.2g} steps: its limit lies far below the motion to be seen",
                             r.integrator, r.steps));
  r.not_known = not_known(e, system);
  return r;
}

}  // namespace feder::experiments
