// Where does each integrator blow up? Bisection on dt: the scene stands at its equilibrium, every free
// coordinate is displaced by a tiny seeded amount, and dt is too long if that grows by the factor kBlownUp.
//   predicted: largest dt with all roots of the linearised step in the unit circle (notes E7, E8)
//   measured:  between the largest stable dt and the smallest that blew up
#include "solvers/stability.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <random>

#include "experiments/support/experiment.h"
#include "models/chain.h"
#include "models/lattice.h"
#include "models/taut_string.h"
#include "solvers/integrators.h"

namespace feder::experiments {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kDisplacement = 1e-9;  // of the scene's length
constexpr double kBlownUp = 1e3;        // growth of the displacement that counts as a blow-up
constexpr double kGone = 1e-3;          // decayed this far, it will not come back
constexpr double kResolution = 2e-4;    // relative width at which the bisection ends
constexpr int kDecadesUp = 5;           // dt tried above sqrt(m / d)
constexpr double kAgreement = 0.01;     // measured against predicted

// ---- Scenes

constexpr int kMasses = 10, kBeads = 20;
constexpr double kMass = 0.01;  // of a node of chain and string [kg]

Model chain(double stiffness, double damping_time) {
  return make_chain(
      {.n = kMasses, .mass = kMass, .stiffness = stiffness, .modes = {}, .damping_time = damping_time});
}

Model taut_string(double stiffness, double tension) {
  return make_taut_string(
      {.n = kBeads, .mass = kMass, .stiffness = stiffness, .tension = tension, .modes = {}});
}

struct Scene {
  const char *name, *title;
  Model (*make)(const Settings& settings, double stiffness);
};

const Scene kScenes[] = {
    {"chain", "chain, undamped", [](const Settings&, double d) { return chain(d, 0.0); }},
    {"chain_damped", "chain, damping ratio 1/2 of the fastest mode",
     [](const Settings&, double d) { return chain(d, 0.5 * std::sqrt(kMass / d)); }},
    {"chain_damping_time", "chain, damping time fixed",
     [](const Settings& settings, double d) { return chain(d, settings.number("damping_time")); }},
    {"lattice", "lattice at rest",
     [](const Settings& settings, double d) {
       const int n = static_cast<int>(settings.integer("lattice"));
       return make_lattice({.n = n, .stiffness = d * (n - 1), .gravity = 0.0});
     }},
    {"string_tension", "taut string, tension fixed",
     [](const Settings& settings, double d) { return taut_string(d, settings.number("tension")); }},
    {"string_strain", "taut string, strain fixed",
     [](const Settings& settings, double d) {
       return taut_string(d, settings.number("strain") * d / (kBeads + 1));
     }},
};

// ---- Methods

// What the bisection has to know about an integrator.
struct Method {
  std::string integrator;
  int steps = 2000;  // of one trial
};

// Steps: enough that growth at 0.5 % above the limit reaches kBlownUp. At (1 + e) times the limit a mode
// grows per step by sqrt(8 e) (leapfrog, notes' step), 7 e (RK4), 2 zeta^2 e (explicit Euler, damping ratio
// zeta < 1).
const Method kMethods[] = {
    {"explicit_euler", 20000},
    {"leapfrog"},
    {"rk4", 3000},
    {"implicit_euler_notes", 500},
    {"implicit_euler_geometric", 60},
    {"implicit_euler_newton", 20},
};

// One method per integrator of THE LIST.
std::vector<Method> methods() {
  std::vector<Method> all;
  for (const IntegratorInfo& integrator : integrator_list()) {
    all.push_back({integrator.name});
    for (const Method& known : kMethods)
      if (known.integrator == integrator.name) all.back() = known;
  }
  return all;
}

// An overdamped mode above the limit of leapfrog grows by 2 e / zeta per step only, zeta = tau / dt.
double steps_needed(const Method& method, const System& system, double limit) {
  if (method.integrator != "leapfrog" || !system.has_damping) return method.steps;
  return method.steps * std::max(1.0, system.damping_time.maxCoeff() / limit);
}

// ---- One trial

struct Trial {
  double growth = 1.0;  // largest displacement over the first one
  int steps = 0;
  Status status = {};  // of the last step
  bool blown_up() const { return !(growth < kBlownUp); }
};

// What stays the same during a bisection.
struct Bench {
  const Model& model;
  const Method& method;
  Integrator integrator;
  std::uint64_t seed;
};

Bench make_bench(const Model& model, const Method& method, std::uint64_t seed, Status& status) {
  Bench bench{model, method, make_integrator(method.integrator, model.system), seed};
  const std::string why = refusal(bench.integrator, model.system);
  status = why.empty() ? std::visit([](auto& i) { return i.prepare(); }, bench.integrator)
                       : Status::failure(StatusCode::kRefused, why);
  return bench;
}

State displaced(const Bench& bench) {
  State state = bench.model.state;
  std::mt19937_64 random(bench.seed);
  const double amplitude = kDisplacement * bench.model.scene_length;
  for (int i = 0; i < state.q.size(); ++i) {
    const double uniform = static_cast<double>(random() >> 11) * 0x1p-53;
    if (bench.model.system.inverse_mass[i] > 0.0) state.q[i] += amplitude * (2.0 * uniform - 1.0);
  }
  return state;
}

Trial try_step(Bench& bench, double dt, int steps) {
  State state = displaced(bench);
  History history;
  const double start = (state.q - bench.model.state.q).norm();
  Trial trial;
  double now = 1.0;
  while (trial.steps < steps && trial.status.ok() && !trial.blown_up() && now > kGone) {
    trial.status = std::visit([&](auto& i) { return i.step(dt, state, history, nullptr); }, bench.integrator);
    now = (state.q - bench.model.state.q).norm() / start;
    if (!(now <= trial.growth)) trial.growth = now;  // keeps a NaN
    ++trial.steps;
  }
  return trial;
}

// ---- The bisection

struct Measured {
  double limit = kNaN;                        // NaN if there is none or it was not found
  double stable = 0.0, blown_up = kInfinity;  // largest dt that is, smallest dt that did
  Status status = {};
};

// Decades up to the first blow-up, decades down to a stable step, then halves between them.
Measured bisect(Bench& bench, double first, double least, int steps) {
  Measured m;
  const auto look = [&](double dt) {
    const Trial trial = try_step(bench, dt, steps);
    if (!trial.blown_up()) m.status = trial.status;
    if (m.status.ok()) (trial.blown_up() ? m.blown_up : m.stable) = dt;
  };
  const double most = first * std::pow(10.0, kDecadesUp + 0.5);
  for (double dt = first; dt < most && m.status.ok() && std::isinf(m.blown_up); dt *= 10.0) look(dt);
  for (double dt = 0.1 * first; dt > least && m.status.ok() && m.stable == 0.0; dt *= 0.1) look(dt);
  if (m.stable == 0.0 || std::isinf(m.blown_up)) return m;
  while (m.status.ok() && m.blown_up > m.stable * (1.0 + kResolution)) look(std::sqrt(m.stable * m.blown_up));
  if (m.status.ok()) m.limit = std::sqrt(m.stable * m.blown_up);
  return m;
}

bool stressed(const Model& model) {
  constexpr double kRounding = 1e-12;
  VectorXd phi;
  evaluate_phi(model.system, model.state.q, phi);
  return phi.lpNorm<Eigen::Infinity>() > kRounding * model.scene_length;
}

Measured measure(const Context& context, const Model& model, const Method& method, double stiffness,
                 double predicted) {
  Measured m;
  Bench bench = make_bench(model, method, context.seed, m.status);
  if (!m.status.ok()) return m;
  if (info(bench.integrator).iterative && stressed(model)) {
    m.status =
        Status::failure(StatusCode::kRefused,
                        "under stress its rest depends on the sweeps: the state it starts from is none "
                        "of its equilibria, and growth from there tells nothing");
    return m;
  }
  const double steps = steps_needed(method, model.system, predicted);
  const auto most_steps = context.settings.integer("most_steps");
  if (steps > static_cast<double>(most_steps)) {
    m.status = Status::failure(
        StatusCode::kLimitReached,
        fmt::format("overdamped: 0.5 % above the limit it takes {:.2g} steps until the growth shows, "
                    "allowed are {}",
                    steps, most_steps));
    return m;
  }
  // where no step is stable, shorter ones only take longer to show it
  const double first = std::sqrt(model.system.inertia.maxCoeff() / stiffness);
  return bisect(bench, first, (predicted == 0.0 ? 0.05 : 1e-8) * first, static_cast<int>(steps));
}

// ---- Tables

std::string reason(const Measured& m) {
  if (!m.status.ok()) return m.status.reason;
  if (!std::isnan(m.limit)) return {};
  return std::isinf(m.blown_up)
             ? fmt::format("no limit found up to dt = {:.3g} s", m.stable)
             : fmt::format("blows up at every step tried, down to dt = {:.3g} s", m.blown_up);
}

Cell if_finite(double x) {
  return std::isfinite(x) ? Cell(x) : Cell();
}

void add_row(Table& table, const Scene& scene, const Method& method, double stiffness,
             const StabilityLimit& predicted, const Measured& m) {
  table.add({{"scene", scene.name},
             {"integrator", method.integrator},
             {"stiffness", stiffness},
             {"dt_predicted", std::isnan(predicted.dt) ? Cell() : Cell(predicted.dt)},
             {"dt_measured", if_finite(m.limit)},
             {"ratio", if_finite(m.limit / predicted.dt)},
             {"dt_stable", m.stable > 0.0 ? Cell(m.stable) : Cell()},
             {"dt_blown_up", if_finite(m.blown_up)},
             {"why", predicted.why},
             {"status", to_string(m.status.code)},
             {"reason", reason(m)}});
}

// The taut string on both sides of the limit of the notes' step (notes E8).
Table string_table(const Context& context) {
  constexpr int kSteps = 5000;
  constexpr std::pair<const char*, double> kTrials[] = {{"implicit_euler_notes", 0.98},
                                                        {"implicit_euler_notes", 1.02},
                                                        {"implicit_euler_geometric", 5.0},
                                                        {"implicit_euler_newton", 5.0}};
  Table table({"integrator", "dt_over_limit", "dt", "steps", "growth", "verdict", "status", "reason"});
  const Model model = taut_string(1e4, context.settings.number("tension"));
  const double limit = stability_limit_notes_step(model.system, model.state).dt;
  for (const auto& [name, factor] : kTrials)
    for (const Method& method : methods()) {
      if (method.integrator != name) continue;
      Trial trial;
      Bench bench = make_bench(model, method, context.seed, trial.status);
      if (trial.status.ok()) trial = try_step(bench, factor * limit, kSteps);
      table.add({{"integrator", name},
                 {"dt_over_limit", factor},
                 {"dt", factor * limit},
                 {"steps", trial.steps},
                 {"growth", trial.growth},
                 {"verdict", trial.blown_up()    ? "blown up"
                             : trial.status.ok() ? "stable"
                                                 : "failed"},
                 {"status", to_string(trial.status.code)},
                 {"reason", trial.status.reason}});
    }
  return table;
}

// ---- Charts

bool is(const Table& table, std::size_t row, const char* column, const std::string& text) {
  return table.at(row, column).text() == text;
}

// Predictions as lines, one per integrator under one label.
void add_predictions(const Table& table, const Scene& scene, Panel& panel) {
  for (const Method& method : methods()) {
    Series line{.label = "predicted", .markers = false, .theory = true};
    for (std::size_t row = 0; row < table.rows(); ++row) {
      if (!is(table, row, "scene", scene.name) || !is(table, row, "integrator", method.integrator)) continue;
      const double dt = table.at(row, "dt_predicted").number();
      if (std::isfinite(dt) && dt > 0.0) line.add(table.at(row, "stiffness").number(), dt);
    }
    if (!line.x.empty()) panel.series.push_back(std::move(line));
  }
}

void add_measurements(const Table& table, const Scene& scene, const char* column, Panel& panel) {
  const std::vector<Method> all = methods();
  for (std::size_t look = 0; look < all.size(); ++look) {
    const auto keep = [&](std::size_t row) {
      return is(table, row, "scene", scene.name) && is(table, row, "integrator", all[look].integrator) &&
             (!table.at(row, column).empty() || !is(table, row, "status", "ok"));
    };
    for (Series& series : series_by(table, "integrator", "stiffness", column, keep)) {
      series.look = look;
      series.line = false;
      panel.series.push_back(std::move(series));
    }
  }
}

Chart limits_chart(const Table& table) {
  Chart chart{
      .name = "stability",
      .title = "Largest stable time step",
      .caption =
          "Measured blow-up (markers) on the predicted limits (dashed). An integrator without markers has no "
          "limit in that scene, or, explicit Euler without damping, no stable step.",
      .grid_columns = 3};
  for (const Scene& scene : kScenes) {
    Panel panel{.title = scene.title,
                .x = {.label = "stiffness d [N/m]", .log = true},
                .y = {.label = "largest stable dt [s]", .log = true}};
    add_predictions(table, scene, panel);
    add_measurements(table, scene, "dt_measured", panel);
    chart.panels.push_back(std::move(panel));
  }
  return chart;
}

Chart ratio_chart(const Table& table) {
  Chart chart{.name = "stability_ratio",
              .title = "Measured over predicted limit",
              .caption = "Every marker should lie inside the band of 1 %.",
              .grid_columns = 3};
  for (const Scene& scene : kScenes) {
    Panel panel{.title = scene.title,
                .x = {.label = "stiffness d [N/m]", .log = true},
                .y = {.label = "measured / predicted", .min = 0.985, .max = 1.015}};
    add_measurements(table, scene, "ratio", panel);
    panel.marks = {{1.0 - kAgreement, "- 1 %", false}, {1.0 + kAgreement, "+ 1 %", false}};
    chart.panels.push_back(std::move(panel));
  }
  return chart;
}

// ---- Conclusions

std::string verdict(const Table& table, const std::string& integrator) {
  double low = kInfinity, high = 0.0;
  int limits = 0, none = 0, never = 0, surprises = 0, failed = 0, open = 0, open_blown_up = 0;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (!is(table, row, "integrator", integrator)) continue;
    const double ratio = table.at(row, "ratio").number(), predicted = table.at(row, "dt_predicted").number();
    if (!is(table, row, "status", "ok")) {
      ++failed;
    } else if (table.at(row, "dt_predicted").empty()) {
      ++open, open_blown_up += !table.at(row, "dt_blown_up").empty();
    } else if (std::isfinite(ratio)) {
      low = std::min(low, ratio), high = std::max(high, ratio), ++limits;
    } else {
      const bool blew_up = !table.at(row, "dt_blown_up").empty();
      ++(predicted == 0.0 && blew_up ? never : std::isinf(predicted) && !blew_up ? none : surprises);
    }
  }
  std::string text = integrator + ":";
  if (limits > 0)
    text += fmt::format(" {} limits at {:.4f} ... {:.4f} of the prediction;", limits, low, high);
  if (low < 1.0 - kAgreement || high > 1.0 + kAgreement) text += " that MISSES the band of 1 %;";
  if (none > 0) text += fmt::format(" no limit predicted and none found in {} cases;", none);
  if (never > 0) text += fmt::format(" no stable step predicted and none found in {} cases;", never);
  if (open > 0) text += fmt::format(" no prediction; a limit found in {} of {} cases;", open_blown_up, open);
  if (surprises > 0) text += fmt::format(" {} cases CONTRADICT the prediction;", surprises);
  if (failed > 0) text += fmt::format(" {} cases not measured (column reason);", failed);
  text.back() = '.';
  return text;
}

std::string string_verdict(const Table& table) {
  std::string text = "Taut string of 20 beads at 1e4 N/m, dt over the limit of the notes' step:";
  for (std::size_t row = 0; row < table.rows(); ++row)
    text += fmt::format(" {} at {:.4g} {} (growth {:.2g} in {} steps);", table.at(row, "integrator").text(),
                        table.at(row, "dt_over_limit").number(), table.at(row, "verdict").text(),
                        table.at(row, "growth").number(), table.at(row, "steps").text());
  text.back() = '.';
  return text;
}

// ---- The experiment

void body(Context& context) {
  const std::vector<double> sweep = context.settings.numbers("stiffness");
  const std::vector<Method> all = methods();
  context.progress.start(static_cast<long>(std::size(kScenes) * sweep.size() * all.size()));
  for (const Scene& scene : kScenes)
    for (const double stiffness : sweep) {
      const Model model = scene.make(context.settings, stiffness);
      for (const Method& method : all) {
        if (context.interrupted()) return;
        const StabilityLimit predicted = stability_limit(method.integrator, model.system, model.state);
        const Measured measured = measure(context, model, method, stiffness, predicted.dt);
        add_row(context.table, scene, method, stiffness, predicted, measured);
        context.progress.advance(fmt::format("{} {}", scene.name, method.integrator));
      }
    }
  const Table string = string_table(context);
  context.add_table("stability_taut_string", string);
  context.add_chart(limits_chart(context.table));
  context.add_chart(ratio_chart(context.table));
  for (const Method& method : all) context.note(verdict(context.table, method.integrator));
  context.note(string_verdict(string));
}

ExperimentInfo about() {
  ExperimentInfo info{
      .name = "stability",
      .question = "Which time step makes each integrator blow up, and was it predicted?",
      .not_modelled =
          "Accuracy below the limit, and motion far from the equilibrium, where frequencies differ.",
      .settings = {{"stiffness", Kind::kNumbers, "1e2:1e8:7", "1e2:1e8:13", "of every spring, N/m"},
                   {"tension", Kind::kNumber, "1", "1", "of the taut string, N"},
                   {"strain", Kind::kNumber, "0.1", "0.1", "of the taut string, tension / (stiffness link)"},
                   {"damping_time", Kind::kNumber, "5e-3", "5e-3",
                    "tau of the chain with fixed damping time, s"},
                   {"lattice", Kind::kInteger, "3", "4", "nodes along an edge of the lattice"},
                   {"most_steps", Kind::kInteger, "40000", "2000000",
                    "of one trial; beyond, the limit is not measured"}},
      .columns = {"scene", "integrator", "stiffness", "dt_predicted", "dt_measured", "ratio", "dt_stable",
                  "dt_blown_up", "why", "status", "reason"}};
  for (const Scene& scene : kScenes) info.cases.emplace_back(scene.name);
  return info;
}

}  // namespace
}  // namespace feder::experiments

int main(int argc, char** argv) {
  return feder::experiments::run_experiment(feder::experiments::about(), argc, argv,
                                            feder::experiments::body);
}
