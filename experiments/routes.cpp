// Which way through the one matrix? Every route solves the same linearisation of the notes' step, at a seeded
// disturbance of the scene, gamma = 1 / (dt^2 d) and 0 for rods (notes E13, E14):
//   [ M  -J^T ; -J  -gamma ] [ v ; dt lambda ] = [ M v_n + dt f ; phi / dt ]
//   velocity error: |v - v*|_M / |v*|_M, after one solve and after refinement of the whole system
//   v*: refined in quadruple precision until that no longer helps; reference_error is the last correction
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <random>

#include "engine/check.h"
#include "experiments/support/experiment.h"
#include "experiments/support/quad_reference.h"
#include "experiments/support/timing.h"
#include "models/chain.h"
#include "models/cloth.h"
#include "models/hanging_chain.h"
#include "models/lattice.h"
#include "solvers/linear/linear_solver.h"

namespace feder::experiments {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kDt = 0.01;  // [s]

// ---- Scenes

struct Scene {
  const char *name, *title;
  double stiffness;  // in the sweep over sizes [N/m]
  Model (*make)(int n, double stiffness);
};

const Scene kScenes[] = {
    {"chain", "chain on a line", 1e4,
     [](int n, double d) { return make_chain({.n = n, .stiffness = d, .modes = {}}); }},
    {"hanging_chain", "hanging chain S1", 1e6,
     [](int n, double d) { return make_hanging_chain({.n = n, .stiffness = d}); }},
    {"cloth", "cloth S2", 1e5,
     [](int n, double d) {
       return make_cloth({.n = n, .stiffness = d, .shear_stiffness = d, .bend_stiffness = 0.1 * d});
     }},
    {"lattice", "lattice S4", 25.0,
     [](int n, double d) { return make_lattice({.n = n, .stiffness = d * (n - 1)}); }},
};

// The same scene with a rod in the place of every spring.
SystemBuilder::Built with_rods(const Model& model) {
  const System& s = model.system;
  SystemBuilder builder;
  for (int i = 0; i < s.nodes; ++i) {
    const Vector3d position = model.state.q.segment<3>(3 * i);
    if (s.mass[i] > 0.0)
      builder.add_particle(s.mass[i], position, Vector3d::Zero(), s.free[i]);
    else
      builder.add_world_point(position);
  }
  for (int k = 0; k < s.distance.size(); ++k)
    if (s.distance.active(k))
      builder.add_distance({s.distance.a[k]}, {s.distance.b[k]}, {kInfinity, 0.0}, s.distance.rest[k]);
  builder.set_gravity(s.forces.gravity);
  return builder.build();
}

SystemBuilder::Built make_scene(const Scene& scene, int n, double stiffness) {
  Model model = scene.make(n, std::isinf(stiffness) ? scene.stiffness : stiffness);
  if (std::isinf(stiffness)) return with_rods(model);
  return {std::move(model.system), std::move(model.state)};
}

// ---- The linearisation

// Moves every free coordinate by up to `disturbance` of the shortest spring, and gives it up to 1 m/s.
void disturb(const System& s, double disturbance, std::uint64_t seed, State& state) {
  double shortest = kInfinity;
  for (int k = 0; k < s.distance.size(); ++k)
    if (s.distance.active(k)) shortest = std::min(shortest, s.distance.rest[k]);
  std::mt19937_64 random(seed);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-52 - 1.0; };
  for (int i = 0; i < state.q.size(); ++i) {
    const double dq = disturbance * shortest * uniform(), v = uniform();
    if (s.inverse_mass[i] == 0.0) continue;
    state.q[i] += dq;
    state.v[i] = v;
  }
}

Status linearise(const System& s, const State& state, Kkt& kkt) {
  kkt.prepare(s);
  kkt.set_step(kDt * kDt, kDt);
  kkt.p = s.inertia.cwiseProduct(state.v) + kDt * s.forces.constant;
  Status status = kkt.evaluate(state.q);
  kkt.r = kkt.phi / kDt;
  return status;
}

// ---- One route

struct Outcome {
  Status status;
  double seconds_analyze = kNaN, seconds_assemble = kNaN, seconds_factor = kNaN, seconds_solve = kNaN;
  double seconds_refine = kNaN, flops = kNaN, error_first = kNaN, error = kNaN, backward_error_first = kNaN;
  SolveReport report;
  bool timed() const { return !std::isnan(seconds_solve); }
  double seconds() const { return seconds_assemble + seconds_factor + seconds_solve; }
};

// Medians over `repeats` factorisations: more where they are short, fewer where they are long.
void time_phases(Kkt& kkt, LinearSolver& solver, int repeats, Outcome& out) {
  constexpr double kLeastSeconds = 0.02, kMostSeconds = 5.0;
  constexpr int kLeastRepeats = 3, kMostRepeats = 100;
  std::vector<double> assemble, factor, solve;
  VectorXd v, y;
  const Stopwatch watch;
  const auto again = [&](int i) {
    const double limit = i < kLeastRepeats  ? kInfinity
                         : i < repeats      ? kMostSeconds
                         : i < kMostRepeats ? kLeastSeconds
                                            : 0.0;
    return watch.seconds() < limit;
  };
  for (int i = 0; again(i); ++i) {
    solver.reset_times();
    if (out.status = solver.factor(kkt); !out.status.ok()) return;
    (void)solver.solve(kkt, v, y).status;
    assemble.push_back(solver.times().assemble);
    factor.push_back(solver.times().factor);
    solve.push_back(solver.times().transfer + solver.times().solve);
  }
  out.seconds_assemble = median(assemble);
  out.seconds_factor = median(factor);
  out.seconds_solve = median(solve);
}

Outcome try_route(Kkt kkt, const std::string& route, const QuadReference& reference, int repeats) {
  const System& s = *kkt.system;
  const SolveOptions once{.accept_below = kInfinity, .most_refinements = 0};
  Outcome out;
  LinearSolver solver(route, once);
  std::vector<double> analyze;
  for (int i = 0; i < 3 && out.status.ok(); ++i) {
    solver.reset_times();
    out.status = solver.analyze(s, false);
    analyze.push_back(solver.times().analyze);
  }
  if (!out.status.ok()) return out;
  out.seconds_analyze = median(analyze);
  out.flops = solver.flops();
  time_phases(kkt, solver, repeats, out);
  if (!out.status.ok()) return out;

  // accuracy: once without and once with refinement
  VectorXd v, y;
  const double scale = mass_norm(s, reference.v);
  const auto error = [&] {
    return std::isnan(reference.error) ? kNaN : mass_norm(s, v - reference.v) / scale;
  };
  out.backward_error_first = solver.solve(kkt, v, y).backward_error;
  out.error_first = error();
  solver.options() = {.estimate_condition = true};
  solver.reset_times();
  out.report = solver.solve(kkt, v, y);
  out.status = out.report.status;
  out.seconds_refine = solver.times().refine;
  out.error = error();
  return out;
}

// ---- One case: all routes on one system

struct Case {
  const Scene& scene;
  const char* sweep;
  int size;
  double stiffness;
};

Cell if_finite(double x) {
  return std::isfinite(x) ? Cell(x) : Cell();
}

void add_row(Table& table, const Case& c, const System& s, const std::string& route, bool chosen,
             const QuadReference& reference, const Outcome& out, double fastest) {
  const SolveReport& report = out.report;
  const auto timed = [&](double x) { return out.timed() ? if_finite(x) : Cell(); };
  const Inertia& inertia = report.inertia;
  table.add({{"scene", c.scene.name},
             {"sweep", c.sweep},
             {"size", c.size},
             {"stiffness", c.stiffness},
             {"dt", kDt},
             {"route", route},
             {"auto", chosen ? "chosen" : ""},
             {"rows", s.active_rows},
             {"unknowns", s.free_count},
             {"status", to_string(out.status.code)},
             {"reason", out.status.reason},
             {"velocity_error_first", if_finite(out.error_first)},
             {"velocity_error", if_finite(out.error)},
             {"reference_error", if_finite(reference.error)},
             {"refinements", timed(report.refinements)},
             {"backward_error_first", if_finite(out.backward_error_first)},
             {"backward_error", timed(report.backward_error)},
             {"balance_error", timed(report.balance_error)},
             {"inertia", out.timed() ? Cell(fmt::format("({}, {}, {})", inertia.positive, inertia.negative,
                                                        inertia.zero))
                                     : Cell()},
             {"rcond", timed(report.rcond)},
             {"flops", if_finite(out.flops)},
             {"seconds_analyze", if_finite(out.seconds_analyze)},
             {"seconds_assemble", if_finite(out.seconds_assemble)},
             {"seconds_factor", if_finite(out.seconds_factor)},
             {"seconds_solve", if_finite(out.seconds_solve)},
             {"seconds_refine", if_finite(out.seconds_refine)},
             {"seconds", if_finite(out.seconds())},
             {"seconds_ratio", if_finite(out.seconds() / fastest)}});
}

struct Choice {
  std::string route, reason;
};

Choice automatic_choice(const System& s) {
  LinearSolver solver("auto");
  const Status status = solver.analyze(s, false);
  return {status.ok() ? solver.route_name() : "none", status.ok() ? solver.choice_reason() : status.reason};
}

void run_case(Context& context, const Case& c, Table& choices) {
  auto [system, state] = make_scene(c.scene, c.size, c.stiffness);
  disturb(system, context.settings.number("disturbance"), context.seed, state);
  Kkt kkt;
  if (Status status = linearise(system, state, kkt); !status.ok()) return context.fail(std::move(status));
  const QuadReference reference = quad_reference(kkt);

  // all routes; dense only where it ends soon
  std::vector<std::string> routes = route_names();
  if (system.active_rows + system.free_count > context.settings.integer("dense")) std::erase(routes, "dense");
  std::vector<Outcome> outcomes;
  std::string fastest_route = "none";
  double fastest = kNaN;
  for (const std::string& route : routes) {
    outcomes.push_back(
        try_route(kkt, route, reference, static_cast<int>(context.settings.integer("repeats"))));
    const double seconds = outcomes.back().seconds();
    if (!outcomes.back().status.ok() || fastest <= seconds) continue;
    fastest = seconds;
    fastest_route = route;
  }
  const Choice choice = automatic_choice(system);
  double ratio = kNaN;
  for (std::size_t i = 0; i < routes.size(); ++i) {
    const bool chosen = routes[i] == choice.route;
    if (chosen) ratio = outcomes[i].seconds() / fastest;
    add_row(context.table, c, system, routes[i], chosen, reference, outcomes[i], fastest);
  }
  choices.add({{"scene", c.scene.name},
               {"sweep", c.sweep},
               {"size", c.size},
               {"stiffness", c.stiffness},
               {"auto", choice.route},
               {"reason", choice.reason},
               {"fastest", fastest_route},
               {"seconds_ratio", if_finite(ratio)}});
}

// ---- Charts

bool is(const Table& table, std::size_t row, const char* column, const std::string& text) {
  return table.at(row, column).text() == text;
}

// One series per route, the same look in every chart.
std::vector<Series> by_route(const Table& table, const Scene& scene, const char* sweep, const char* x,
                             const char* y) {
  std::vector<Series> all;
  const std::vector<std::string> routes = route_names();
  for (std::size_t look = 0; look < routes.size(); ++look)
    for (Series& series : series_by(table, "route", x, y, [&](std::size_t row) {
           return is(table, row, "scene", scene.name) && is(table, row, "sweep", sweep) &&
                  is(table, row, "route", routes[look]);
         })) {
      series.look = look;
      all.push_back(std::move(series));
    }
  return all;
}

Chart total_chart(const Table& table) {
  Chart chart{
      .name = "routes_seconds",
      .title = "Time of one factorisation and solve",
      .caption =
          "Assembling, factoring and solving once, analysis reused, against the number of free coordinates."};
  for (const Scene& scene : kScenes)
    chart.panels.push_back({.title = scene.title,
                            .x = {.label = "free coordinates", .log = true},
                            .y = {.label = "assemble + factor + solve [s]", .log = true},
                            .series = by_route(table, scene, "size", "unknowns", "seconds")});
  return chart;
}

Chart phases_chart(const Table& table) {
  constexpr std::pair<const char*, const char*> kPhases[] = {
      {"assemble", "seconds_assemble"}, {"factor", "seconds_factor"}, {"solve", "seconds_solve"}};
  Chart chart{.name = "routes_phases",
              .title = "Time of each phase",
              .caption = "The phases of routes_seconds, one by one.",
              .grid_columns = 3};
  for (const Scene& scene : kScenes)
    for (const auto& [phase, column] : kPhases)
      chart.panels.push_back({.title = fmt::format("{}: {}", scene.title, phase),
                              .x = {.label = "free coordinates", .log = true},
                              .y = {.label = "seconds [s]", .log = true},
                              .series = by_route(table, scene, "size", "unknowns", column)});
  return chart;
}

// Rods are drawn two decades right of the stiffest spring, errors of 0 at the bottom.
void make_drawable(Series& series, double rods) {
  constexpr double kLeastError = 1e-17;
  for (double& x : series.x) x = std::min(x, rods);
  for (double& x : series.failed_x) x = std::min(x, rods);
  for (double& y : series.y) y = std::max(y, kLeastError);
}

Chart accuracy_chart(const Table& table, double rods) {
  constexpr std::pair<const char*, const char*> kColumns[] = {{"first solve", "velocity_error_first"},
                                                              {"after refinement", "velocity_error"}};
  Chart chart{
      .name = "routes_accuracy",
      .title = "Velocity error of the routes",
      .caption =
          "Error against a solution in quadruple precision; crosses are routes that refuse or fail, the mark "
          "on the right stands for rods in place of all springs.",
      .grid_columns = 2};
  for (const Scene& scene : kScenes)
    for (const auto& [when, column] : kColumns) {
      Panel panel{.title = fmt::format("{}: {}", scene.title, when),
                  .x = {.label = "stiffness d [N/m]", .log = true},
                  .y = {.label = "relative velocity error", .log = true, .min = 1e-17, .max = 1e-2},
                  .series = by_route(table, scene, "stiffness", "stiffness", column),
                  .marks = {{rods, "rods", true}}};
      for (Series& series : panel.series) make_drawable(series, rods);
      chart.panels.push_back(std::move(panel));
    }
  return chart;
}

// ---- Conclusions

void note_choice(Context& context, const Table& choices, const Scene& scene) {
  std::string text;
  for (std::size_t row = 0; row < choices.rows(); ++row)  // the largest size comes last
    if (is(choices, row, "scene", scene.name) && is(choices, row, "sweep", "size"))
      text =
          fmt::format("{}, size {}: auto takes {}; fastest measured: {}; auto needs {:.2f} times its time.",
                      scene.title, choices.at(row, "size").text(), choices.at(row, "reason").text(),
                      choices.at(row, "fastest").text(), choices.at(row, "seconds_ratio").number());
  context.note(text);
}

// Largest error of a route over the springs of the stiffness sweep, and how it fares with rods.
void note_accuracy(Context& context, const Scene& scene) {
  const Table& table = context.table;
  std::string text =
      fmt::format("{}, velocity error at the stiffest spring, first solve -> refined:", scene.title);
  for (const std::string& route : route_names()) {
    std::string springs, rods;
    for (std::size_t row = 0; row < table.rows(); ++row) {
      if (!is(table, row, "scene", scene.name) || !is(table, row, "sweep", "stiffness") ||
          !is(table, row, "route", route))
        continue;
      const std::string status = table.at(row, "status").text();
      const std::string errors =
          fmt::format("{:.1e} -> {:.1e}{}", table.at(row, "velocity_error_first").number(),
                      table.at(row, "velocity_error").number(), status == "ok" ? "" : " " + status);
      const bool solved = !table.at(row, "velocity_error").empty();
      (std::isinf(table.at(row, "stiffness").number()) ? rods : springs) = solved ? errors : status;
    }
    if (!springs.empty()) text += fmt::format(" {} {}, rods {};", route, springs, rods);
  }
  text.back() = '.';
  context.note(text);
}

// ---- The experiment

void body(Context& context) {
  std::vector<double> stiffnesses = context.settings.numbers("stiffness");
  const double rods = 100.0 * stiffnesses.back();
  const auto which = context.settings.integer("sweep_size");
  stiffnesses.push_back(kInfinity);
  std::vector<Case> cases;
  for (const Scene& scene : kScenes) {
    const std::vector<double> sizes = context.settings.numbers(scene.name);
    if (which < 1 || which > std::ssize(sizes))
      fail_input("setting sweep_size", scene.name, static_cast<double>(which), "",
                 "a place in its list of sizes");
    for (const double n : sizes) cases.push_back({scene, "size", static_cast<int>(n), scene.stiffness});
    for (const double d : stiffnesses)
      cases.push_back({scene, "stiffness", static_cast<int>(sizes[static_cast<std::size_t>(which) - 1]), d});
  }
  Table choices({"scene", "sweep", "size", "stiffness", "auto", "reason", "fastest", "seconds_ratio"});
  context.progress.start(static_cast<long>(cases.size()));
  for (const Case& c : cases) {
    if (context.interrupted()) return;
    run_case(context, c, choices);
    context.progress.advance(fmt::format("{} {}", c.scene.name, c.size));
  }
  context.add_chart(total_chart(context.table));
  context.add_chart(phases_chart(context.table));
  context.add_chart(accuracy_chart(context.table, rods));
  for (const Scene& scene : kScenes) note_choice(context, choices, scene);
  for (const Scene& scene : kScenes) note_accuracy(context, scene);
  context.add_table("routes_auto", std::move(choices));
}

ExperimentInfo about() {
  ExperimentInfo info{
      .name = "routes",
      .question = "Which route through the step matrix is fastest, and how accurate is its velocity?",
      .not_modelled =
          "Geometric stiffness, more than one thread, and keeping a factorisation over several steps.",
      .settings =
          {{"chain", Kind::kNumbers, "100,1000,10000", "100,1000,10000,100000", "masses of the chain"},
           {"hanging_chain", Kind::kNumbers, "50,500,5000", "50,500,5000,50000",
            "masses of the hanging chain"},
           {"cloth", Kind::kNumbers, "6,12,24,36", "6,12,25,50,100", "nodes along an edge of the cloth"},
           {"lattice", Kind::kNumbers, "3,5,7", "3,5,8,12,16", "nodes along an edge of the lattice"},
           {"stiffness", Kind::kNumbers, "1e2:1e14:7", "1e2:1e14:13",
            "of the springs in the sweep over stiffness, N/m; rods are added"},
           {"sweep_size", Kind::kInteger, "1", "2", "which of the sizes that sweep takes, from 1"},
           {"disturbance", Kind::kNumber, "1e-3", "1e-3", "of the nodes, over the shortest spring"},
           {"dense", Kind::kInteger, "300", "700", "rows and unknowns up to which the dense route runs"},
           {"repeats", Kind::kInteger, "5", "9", "factorisations timed at least"}},
      .columns = {"scene",
                  "sweep",
                  "size",
                  "stiffness",
                  "dt",
                  "route",
                  "auto",
                  "rows",
                  "unknowns",
                  "status",
                  "reason",
                  "velocity_error_first",
                  "velocity_error",
                  "reference_error",
                  "refinements",
                  "backward_error_first",
                  "backward_error",
                  "balance_error",
                  "inertia",
                  "rcond",
                  "flops",
                  "seconds_analyze",
                  "seconds_assemble",
                  "seconds_factor",
                  "seconds_solve",
                  "seconds_refine",
                  "seconds",
                  "seconds_ratio"}};
  for (const Scene& scene : kScenes) info.cases.emplace_back(scene.name);
  return info;
}

}  // namespace
}  // namespace feder::experiments

int main(int argc, char** argv) {
  return feder::experiments::run_experiment(feder::experiments::about(), argc, argv,
                                            feder::experiments::body);
}
