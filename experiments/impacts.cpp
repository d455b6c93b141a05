// What does each impact rule do to the energy (notes D5, D6)? A slender rod, half length l, falls on its
// lower end at the angle theta to the ground. With u = (u_n, u_t) the velocity of that end, W its 2 x 2
// Delassus matrix,
//   W_nn = (1 + 3 cos^2)/m,  W_tt = (1 + 3 sin^2)/m,  W_nt = -3 sin cos / m
// the energy an impact can take is 1/2 u.W^-1 u; the change is counted against it. Sliding pushes the end
// into the ground by itself (Painleve) where W_nn < mu |W_nt|: mu > (1 + 3 cos^2)/(3 sin cos), 4/3 at
// tan(theta) = 2.
#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "experiments/support/experiment.h"
#include "solvers/contact/body_contact.h"
#include "solvers/contact/impact_law.h"

namespace feder::experiments {
namespace {

constexpr double kGain = 1e-12;  // of the contact energy: above, an impact has gained

struct Rule {
  const char* name;
  ImpactRule rule;
};
constexpr Rule kRules[] = {
    {"naive", ImpactRule::kNaive}, {"poisson", ImpactRule::kPoisson}, {"stronge", ImpactRule::kStronge}};

// Mass 1 kg, half length 1 m; it turns about y alone.
ContactBody rod(double angle) {
  return {1.0, Vector3d(0.0, 3.0, 0.0).asDiagonal(), {-std::cos(angle), 0.0, -std::sin(angle)}};
}

struct Sweep {
  long states = 0, gaining = 0, unsolved = 0, jammed = 0;
  double largest = -1.0, smallest = 0.0, sum = 0.0;  // change over contact energy

  void add(const ImpactResult& impact, double energy) {
    ++states;
    if (impact.status != StatusCode::kOk) {
      ++unsolved;
      return;
    }
    const double change = impact.energy_change / energy;
    gaining += change > kGain;
    jammed += impact.jammed;
    largest = std::max(largest, change);
    smallest = std::min(smallest, change);
    sum += change;
  }
};

// Angles x slips x spins; the end comes down with 1 m/s before the spin is added.
Sweep sweep(const Context& context, const Rule& rule, double friction, double restitution) {
  Sweep out;
  const std::int64_t angles = context.settings.integer("angles"), speeds = context.settings.integer("speeds");
  const Matrix3d axes = contact_axes(Vector3d::UnitZ());
  for (std::int64_t i = 1; i <= angles; ++i) {
    const ContactBody body =
        rod(0.5 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(angles + 1));
    const Matrix3d W = contact_inverse_mass({}, body, axes);
    const Eigen::Matrix2d mass = W.topLeftCorner<2, 2>().inverse();
    for (std::int64_t slip = -speeds; slip <= speeds; ++slip)
      for (std::int64_t spin = -speeds; spin <= speeds; ++spin) {
        const double unit = 3.0 / static_cast<double>(speeds);
        const BodyVelocity velocity{{unit * static_cast<double>(slip), 0.0, -1.0},
                                    {0.0, 2.0 * unit * static_cast<double>(spin), 0.0}};
        const Vector3d u = contact_velocity({}, {}, body, velocity, axes);
        if (u[0] >= 0.0) continue;
        out.add(resolve_impact(W, u, friction, restitution, rule.rule),
                0.5 * u.head<2>().dot(mass * u.head<2>()));
      }
  }
  return out;
}

void add_row(Context& context, const Rule& rule, double friction, double restitution, const Sweep& s) {
  context.table.add(
      {{"scene", "rod on its end"},
       {"rule", rule.name},
       {"friction", friction},
       {"restitution", restitution},
       {"status", s.unsolved == 0 ? "ok" : "refused"},
       {"reason", s.unsolved == 0 ? "" : fmt::format("{} states without an impulse >= 0", s.unsolved)},
       {"states", static_cast<std::int64_t>(s.states)},
       {"gaining", static_cast<std::int64_t>(s.gaining)},
       {"jammed", static_cast<std::int64_t>(s.jammed)},
       {"largest_change", s.largest},
       {"mean_change", s.sum / static_cast<double>(std::max(1L, s.states - s.unsolved))},
       {"smallest_change", s.smallest}});
}

void sweep_rules(Context& context) {
  Panel share{.x = {"friction coefficient mu"}, .y = {"share of states [%]"}};
  Panel largest{.x = {"friction coefficient mu"}, .y = {"change / contact energy"}};
  const std::vector<double> frictions = context.settings.numbers("friction"),
                            rebounds = context.settings.numbers("restitution");
  context.progress.start(static_cast<long>(std::size(kRules) * frictions.size() * rebounds.size()));
  for (std::size_t r = 0; r < std::size(kRules); ++r) {
    const Rule& rule = kRules[r];
    Series gains{.label = rule.name, .look = r}, changes = gains;
    Sweep total;
    for (double friction : frictions)
      for (double restitution : rebounds) {
        if (context.interrupted()) return;
        const Sweep s = sweep(context, rule, friction, restitution);
        add_row(context, rule, friction, restitution, s);
        total.states += s.states, total.gaining += s.gaining, total.unsolved += s.unsolved;
        total.largest = std::max(total.largest, s.largest);
        if (restitution == rebounds.back()) {
          gains.add(friction, 100.0 * static_cast<double>(s.gaining) / static_cast<double>(s.states));
          changes.add(friction, s.largest);
        }
        context.progress.advance(rule.name);
      }
    share.series.push_back(std::move(gains));
    largest.series.push_back(std::move(changes));
    context.note(
        fmt::format("{}: {} of {} states gain energy ({:.2f} %), at most {:+.2e} of the contact energy; {} "
                    "without an impulse.",
                    rule.name, total.gaining, total.states,
                    100.0 * static_cast<double>(total.gaining) / static_cast<double>(total.states),
                    total.largest, total.unsolved));
  }
  share.title = fmt::format("States that gain energy, e = {}", rebounds.back());
  largest.title = fmt::format("Largest change of energy, e = {}", rebounds.back());
  context.add_chart({.name = "impacts",
                     .title = "Impacts of a rod on its end: energy by rule and friction",
                     .caption = "Newton's restitution with friction against the first slip gains energy; the "
                                "energetic rule never does.",
                     .panels = {std::move(share), std::move(largest)}});
}

void draw_painleve(Context& context) {
  Panel panel{.title = "Sliding jams above the curve",
              .x = {"angle of the rod [degrees]"},
              .y = {.label = "friction coefficient mu", .log = true, .min = 1.0, .max = 100.0}};
  Series curve{.label = "W_nn / |W_nt|", .markers = false};
  double least = std::numeric_limits<double>::infinity(), at = 0.0;
  for (int i = 1; i < 1800; ++i) {
    const double angle = 0.5 * std::numbers::pi * i / 1800.0;
    const double critical =
        critical_friction(contact_inverse_mass({}, rod(angle), contact_axes(Vector3d::UnitZ())));
    curve.add(angle * 180.0 / std::numbers::pi, critical);
    if (critical < least) least = critical, at = angle;
  }
  panel.series.push_back(std::move(curve));
  panel.marks = {{.at = 4.0 / 3.0, .label = "4/3", .vertical = false},
                 {.at = std::atan(2.0) * 180.0 / std::numbers::pi, .label = "tan = 2"}};
  context.note(fmt::format(
      "A sliding rod can jam from mu = {:.6f} on, at tan(angle) = {:.4f} (closed form 4/3 and 2).", least,
      std::tan(at)));
  context.add_chart({.name = "painleve",
                     .title = "Painleve: where sliding pushes the rod into the ground",
                     .caption = "Critical friction of a slender rod sliding on its end.",
                     .panels = {std::move(panel)}});
}

void body(Context& context) {
  sweep_rules(context);
  if (!context.interrupted()) draw_painleve(context);
}

ExperimentInfo info() {
  return {.name = "impacts",
          .question = "What does each impact rule do to the energy, and where does sliding jam?",
          .not_modelled =
              "One contact alone and rigid bodies: no waves in the rod, no second impact of its other end.",
          .settings = {{"friction", Kind::kNumbers, "0:1.6:9:lin", "0:2:41:lin", "friction coefficients"},
                       {"restitution", Kind::kNumbers, "0:1:3:lin", "0:1:11:lin",
                        "coefficients of restitution; the charts show the last"},
                       {"angles", Kind::kInteger, "22", "88", "angles between flat and upright"},
                       {"speeds", Kind::kInteger, "10", "20", "slips and spins to each side of 0"}},
          .columns = {"scene", "rule", "friction", "restitution", "status", "reason", "states", "gaining",
                      "jammed", "largest_change", "mean_change", "smallest_change"},
          .cases = {"rod on its end: naive, poisson, stronge"}};
}

}  // namespace
}  // namespace feder::experiments

int main(int argc, char** argv) {
  return feder::experiments::run_experiment(feder::experiments::info(), argc, argv, feder::experiments::body);
}
