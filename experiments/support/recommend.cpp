// Which method and step for a scene. The rules, and where their figures were measured:
//  1 20 or more dependent hard rows, or rank unknown: implicit_euler_newton (the others stop at 28, plates)
//  2 other hard rows: rk4 with projection, 0.05 rad of the fastest turning or swing per step (`mechanisms`:
//    error 1e-6 ... 1e-4 of the scene at 0.03 ... 0.06 rad, cheapest there below 1e-2) and 0.25 rad of the
//    fastest spring (four-bar with a spring of 505 rad/s: it lost 93 % of its energy at 1.9 rad, 5 % at 0.5)
//  3 damped rows, user forces, springs with a law: rk4 (leapfrog would solve a system, or not be symplectic)
//  4 the start moves springs or bodies by more than 0.25 or 0.05 rad per step of leapfrog: rk4 at that step
//  5 all others: leapfrog at 0.9 of its limit (`work_precision`: cheapest below 1e-3 of the scene's length)
//  6 2 to 5 need over a million steps, or no frequency is known: implicit_euler_newton, 0.02 rad of the whole
//    scene's motion per step (`work_precision`: 0.3 ... 1.5 % of the scene's length on S1, S2, S4)
// rk4 stays below 0.9 kRk4Radius / rate, rate = (c + sqrt(c^2 + 4 omega^2))/2 >= |s| of every root.
#include "experiments/support/recommend.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/fluid/fluid.h"
#include "solvers/stability.h"

namespace feder::experiments {
namespace {

constexpr int kManyDependent = 20;
constexpr double kPhaseTurn = 0.05, kPhaseSpring = 0.25, kPhaseImplicit = 0.02;  // per step [rad]
constexpr double kBelowLimit = 0.9;
constexpr double kMostSteps = 1e6, kFewestSteps = 100.0;

// What a step must resolve: a rate, its name, and how much of it.
struct Motion {
  double rate = 0.0;  // [rad/s]
  std::string name = {};
  double phase = 1.0;  // [rad]
  double dt() const { return phase / rate; }
  std::string text() const { return fmt::format("turns {} ({:.3g} rad/s) by {} rad", name, rate, phase); }
};

Motion smooth_motion(const Explanation& e) {
  Motion shortest;
  // with hard rows nobody knows what the start excites: all of it
  const double springs = e.all_rows.hard > 0 ? e.largest_frequency : e.excited_frequency;
  for (const Motion& motion : {Motion{e.turning_rate, "the fastest-turning part at the start", kPhaseTurn},
                               Motion{e.swing_rate, "a free swing of the smallest part", kPhaseTurn},
                               Motion{springs, "the springs' motion", kPhaseSpring}})
    if (motion.dt() < shortest.dt()) shortest = motion;
  return shortest;
}

// The scene as a whole: what an implicit method of first order can still show.
Motion whole_motion(const Explanation& e, const System& system) {
  const double fall = std::sqrt(system.forces.gravity.norm() / e.scene_length);
  if (fall > e.turning_rate) return {fall, "a fall through the scene's length", kPhaseImplicit};
  if (e.turning_rate > 0.0) return {e.turning_rate, "the fastest-turning part at the start", kPhaseImplicit};
  if (e.smallest_frequency > 0.0) return {e.smallest_frequency, "the slowest mode", kPhaseImplicit};
  return {2.0 * std::numbers::pi / e.end_time, "one period in the run", kPhaseImplicit};
}

double largest_rate(const Explanation& e) {
  const double c = e.largest_damping_rate, omega = e.largest_frequency;
  return 0.5 * (c + std::sqrt(c * c + 4.0 * omega * omega));
}

// Takes `dt`, or a hundredth of the run where that is shorter, and says so in `why`.
void set_step(Recommendation& r, double dt, double end_time) {
  r.dt = std::min(dt, end_time / kFewestSteps);
  r.steps = std::ceil(end_time / r.dt - 1e-9);
  if (r.dt < dt) r.why += " Shortened to a hundredth of the run.";
}

Recommendation implicit(const Explanation& e, const System& system, const std::string& because) {
  const Motion whole = whole_motion(e, system);
  Recommendation r{.integrator = "implicit_euler_newton", .why = {}, .not_known = {}};
  r.why =
      fmt::format("{}. The step {}: errors near 1 % of the scene's length, and faster motion is damped away.",
                  because, whole.text());
  set_step(r, whole.dt(), e.end_time);
  return r;
}

bool forces_beyond_rows(const System& system) {
  return system.forces.user || !system.law_springs.empty() || (system.fluid && system.fluid->dissipates());
}

std::string reason_for_rk4(const Explanation& e, const System& system) {
  if (e.all_rows.hard > 0) return "Hard rows held by projection at order 4; ";
  if (e.all_rows.damped > 0) return "Damped rows, taken explicitly at order 4; ";
  if (forces_beyond_rows(system)) return "Forces beyond rows, order 4; ";
  if (e.largest_frequency > 0.0) return "The start moves the springs themselves, where order 4 pays; ";
  return "Smooth motion without springs, where order 4 pays; ";
}

Recommendation rk4(const Explanation& e, const System& system, const Motion& smooth) {
  const double stable = kBelowLimit * kRk4Radius / largest_rate(e);
  Recommendation r{.integrator = "rk4", .why = reason_for_rk4(e, system), .not_known = {}};
  if (stable < smooth.dt())
    r.why += fmt::format("the step is 0.9 of what the finite rows allow (rate {:.3g} 1/s).", largest_rate(e));
  else
    r.why += smooth.rate > 0.0 ? "the step " + smooth.text() + "." : "no rate is known.";
  set_step(r, std::min(smooth.dt(), stable), e.end_time);
  return r;
}

Recommendation explicit_method(const Explanation& e, const System& system) {
  const Motion smooth = smooth_motion(e);
  const double dt = kBelowLimit * 2.0 / e.largest_frequency;
  if (e.all_rows.hard > 0 || e.all_rows.damped > 0 || forces_beyond_rows(system) ||
      e.largest_frequency == 0.0 || dt > smooth.dt())
    return rk4(e, system, smooth);
  Recommendation r{.integrator = "leapfrog",
                   .why =
                       "Undamped springs and nothing hard: one force evaluation per step, symplectic, at 0.9 "
                       "of the limit 2 / omega_max.",
                   .not_known = {}};
  set_step(r, dt, e.end_time);
  return r;
}

std::string not_known(const Explanation& e, const System& system) {
  std::string text = "Not known: rates reached later in the run";
  if (system.driven()) text += ", how fast driven parts will move";
  if (system.forces.user && !system.forces.user.stiffness) text += ", the stiffness of the user force";
  if (!system.law_springs.empty()) text += ", the damping of springs with a law";
  if (system.fluid && !system.fluid->incompressible()) text += ", how far the fluid will be compressed";
  if (e.all_rows.hard > 0) text += ", poses where hard rows lose rank";
  return text + ", the error you accept; halve dt to see it.";
}

// A quarter of a fall through the support of the kernel.
Recommendation incompressible(const Explanation& e, const System& system) {
  Recommendation r{
      .integrator = "symplectic_euler",
      .why =
          "An incompressible fluid, for whose density it alone has rows; a quarter of the time of "
          "a fall through the support of the kernel.",
      .not_known = {}};
  const double fall = std::sqrt(system.fluid->material().support / system.forces.gravity.norm());
  set_step(r, std::min(0.25 * fall, e.end_time), e.end_time);
  return r;
}

}  // namespace

Recommendation recommend(const Explanation& e, const System& system) {
  Recommendation r;
  if (e.unknowns == 0) {
    r.why = "Nothing can move.";
    return r;
  }
  if (system.fluid && system.fluid->incompressible())
    r = incompressible(e, system);
  else if (e.all_rows.hard > 0 && e.rank < 0)
    r = implicit(e, system, "The rank of the hard rows is not known: only Newton takes any");
  else if (e.dependent >= kManyDependent)
    r = implicit(e, system, fmt::format("{} dependent hard rows, where the other methods stop", e.dependent));
  else if (std::isnan(largest_rate(e)) || std::isnan(e.excited_frequency))
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
