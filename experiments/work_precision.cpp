// What does a given accuracy cost? Error against seconds over integrators x linear routes x time steps.
//   error: mass-weighted rms position at the end against the exact solution or the judge [m]
//   seconds: the step loop alone, best of several runs
//   explicit methods: dt in fractions of leapfrog's limit 2 / omega_max, from just above the limits of
//   leapfrog and RK4 down, so that the blow-up is part of the result; implicit ones: from 1/60 s down
#include <fmt/format.h>

#include <cmath>

#include "engine/check.h"
#include "experiments/support/experiment.h"
#include "experiments/support/measure.h"
#include "experiments/support/timing.h"
#include "models/catalog.h"
#include "solvers/reference.h"
#include "solvers/simulate.h"
#include "solvers/stability.h"

namespace feder::experiments {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kEnoughSeconds = 0.02;  // of runs shorter than this as many as fit are timed
constexpr int kMostRepeats = 20;
constexpr double kLevels[] = {1e-1, 1e-2, 1e-3, 1e-4};  // of the scene's length

const ExperimentInfo kInfo{
    .name = "work_precision",
    .question = "Which integrator, linear route and time step reach a given accuracy at the lowest cost?",
    .not_modelled =
        "Hard rows (no judge admits them), step-size control, several threads, and the analysis "
        "before the first step.",
    .settings =
        {{"scenes", Kind::kTexts, "S1(100),S2(10),S4(6),chain",
          "S1(100),S1(1000),S2(20),S2(50),S4(10),S4s(10)", "models with at most one parameter each"},
         {"explicit_fractions", Kind::kNumbers, "1.5,1.05,0.9,0.45,0.2,0.1,0.05,0.01",
          "1.5,1.05,0.9,0.45,0.2,0.1,0.05,0.02,0.01,0.003",
          "time steps of explicit methods, fractions of 2 / omega_max"},
         {"implicit_rates", Kind::kNumbers, "60:1920:6", "60:7680:8", "steps per second of implicit methods"},
         {"routes", Kind::kTexts, "kkt,primal,dual", "kkt,primal,dual", "linear routes of implicit methods",
          [] {
            std::vector<std::string> names = route_names();
            names.push_back("auto");
            return names;
          }()},
         {"judge_tolerance", Kind::kNumber, "1e-9", "1e-11", "relative tolerance of the judge's finer run"},
         {"repeats", Kind::kInteger, "2", "3", "runs per timing, more of short ones"},
         {"max_seconds", Kind::kNumber, "0.1", "3", "budget of a run and of its repeats, s"}},
    .columns = {"scene", "integrator", "route", "dt", "status", "reason", "steps", "error", "reference_error",
                "energy_drift", "seconds", "seconds_assemble", "seconds_factor", "seconds_solve",
                "scene_length", "seconds_whole_run"},
    .cases = {"S1(n): chain of stiff springs", "S2(n): cloth", "S4(n), S4s(n): lattice",
              "chain: exact modes"}};

// ---- Scenes and their judge

struct Scene {
  std::string name;
  Model model;
  double end = 0.0;      // [s]
  Reference judge;       // at the end
  double limit = kNone;  // 2 / omega_max [s]
};

Reference exact_reference(const Model& model, double end) {
  return {{},
          model.exact(end),
          std::numeric_limits<double>::epsilon() * model.scene_length,
          "exact solution",
          false};
}

Reference judge(const Context& context, const Model& model, double end) {
  const double tolerance = context.settings.number("judge_tolerance");
  ReferenceOptions options;
  options.judge.relative_tolerance = tolerance;
  options.judge.position_tolerance = 1e-2 * tolerance;
  options.judge.velocity_tolerance = 1e-1 * tolerance;
  return make_reference(model.system, model.state, end, options);
}

Scene make_scene(Context& context, const std::string& spec) {
  Scene scene{spec, make_model(spec), 0.0, {}, kNone};
  const Model& model = scene.model;
  scene.end = observation_time(model);
  scene.judge = model.exact ? exact_reference(model, scene.end) : judge(context, model, scene.end);
  const Status& status = scene.judge.status;
  if (status.ok())
    context.note(
        fmt::format("Judge of {}: {}, own error {:.1e} m.", spec, scene.judge.method, scene.judge.error));
  else
    context.fail(Status::failure(status.code, "the judge on " + spec + ": " + status.reason));
  scene.limit = 2.0 / largest_frequency(model.system, model.state);
  // no prediction, for instance with hard rows
  if (!std::isfinite(scene.limit)) scene.limit = 1e-3 * scene.end;
  return scene;
}

// ---- One run

struct Run {
  std::string route = "none";
  double dt = 0.0;
  Status status;
  double steps = 0.0, error = kNone, drift = kNone, seconds = 0.0;
  double assemble = kNone, factor = kNone, solve = kNone;
  // What the run would have cost to its end, had it not failed.
  double whole_run(double end) const {
    return steps > 0.0 ? seconds * std::ceil(end / dt - 1e-9) / steps : kNone;
  }
};

Run run_once(const Scene& scene, const std::string& name, const std::string& route, double dt,
             double budget) {
  const System& system = scene.model.system;
  IntegratorOptions integrator_options;
  if (route != "none") integrator_options.route = route;
  Integrator integrator = make_integrator(name, system, integrator_options);
  State state = scene.model.state;
  History history;
  RunOptions options;
  options.dt = dt, options.end_time = scene.end, options.max_seconds = budget;
  RunResult result = simulate(system, integrator, state, history, options);

  Run run{.route = route,
          .dt = dt,
          .status = std::move(result.status),
          .steps = static_cast<double>(result.steps),
          .seconds = result.seconds};
  if (run.status.ok()) {
    run.error = position_error(system, state, scene.judge.state);
    run.drift =
        (total_energy(system, state) - total_energy(system, scene.model.state)) / energy_scale(scene.model);
  }
  if (const LinearSolver* solver = route == "none" ? nullptr : linear_solver(integrator)) {
    const PhaseTimes& times = solver->times();
    run.assemble = times.assemble;
    run.factor = times.factor;
    run.solve = times.solve + times.transfer + times.residual + times.refine;
  }
  return run;
}

// The fastest of several; a failure is not repeated.
Run run_best(const Context& context, const Scene& scene, const std::string& name, const std::string& route,
             double dt) {
  const double budget = context.settings.number("max_seconds");
  Run best = run_once(scene, name, route, dt, budget);
  const auto repeats = static_cast<int>(context.settings.integer("repeats"));
  double spent = best.seconds;
  for (int i = 1; best.status.ok() && !context.interrupted() && i < kMostRepeats && spent < budget &&
                  (i < repeats || spent < kEnoughSeconds);
       ++i) {
    Run again = run_once(scene, name, route, dt, budget);
    spent += again.seconds;
    if (again.status.ok() && again.seconds < best.seconds) best = std::move(again);
  }
  return best;
}

Cell cell(double value) {
  return std::isfinite(value) ? Cell(value) : Cell();
}

void add_row(Context& context, const Scene& scene, const IntegratorInfo& method, const Run& run) {
  context.table.add({{"scene", scene.name},
                     {"integrator", method.name},
                     {"route", run.route},
                     {"dt", run.dt},
                     {"status", to_string(run.status.code)},
                     {"reason", run.status.reason},
                     {"steps", static_cast<std::int64_t>(run.steps)},
                     {"error", cell(run.error)},
                     {"reference_error", scene.judge.error},
                     {"energy_drift", cell(run.drift)},
                     {"seconds", run.seconds},
                     {"seconds_assemble", cell(run.assemble)},
                     {"seconds_factor", cell(run.factor)},
                     {"seconds_solve", cell(run.solve)},
                     {"scene_length", scene.model.scene_length},
                     {"seconds_whole_run", cell(run.whole_run(scene.end))}});
}

std::vector<double> steps_of(const Context& context, const Scene& scene, const IntegratorInfo& method) {
  std::vector<double> steps;
  if (method.implicit)
    for (const double rate : context.settings.numbers("implicit_rates")) steps.push_back(1.0 / rate);
  else
    for (const double fraction : context.settings.numbers("explicit_fractions"))
      steps.push_back(fraction * scene.limit);
  std::erase_if(steps, [&](double dt) { return dt > scene.end; });
  return steps;
}

void study(Context& context, const Scene& scene, const IntegratorInfo& method, const std::string& route) {
  for (const double dt : steps_of(context, scene, method)) {
    if (context.interrupted()) return;
    const Run run = run_best(context, scene, method.name, route, dt);
    add_row(context, scene, method, run);
    // refused at one step is refused at all, and a finer one costs more
    if (run.status.code == StatusCode::kRefused || run.status.code == StatusCode::kLimitReached) return;
  }
}

// ---- Chart

// Over the routes the cheapest run of every dt; a cross where none of them succeeded.
Series front_of(const Table& table, const std::string& scene, const std::string& integrator) {
  struct Best {
    double dt, seconds = HUGE_VAL, error = kNone, floor = kNone, failed = HUGE_VAL;
  };
  std::vector<Best> all;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (table.at(row, "scene").text() != scene || table.at(row, "integrator").text() != integrator) continue;
    const double dt = table.at(row, "dt").number(), length = table.at(row, "scene_length").number();
    auto best = std::find_if(all.begin(), all.end(), [&](const Best& b) { return b.dt == dt; });
    if (best == all.end()) best = all.insert(all.end(), Best{dt});
    const double seconds = table.at(row, "seconds_whole_run").number();
    if (table.at(row, "status").text() != "ok")
      best->failed = std::min(best->failed, std::isfinite(seconds) ? seconds : HUGE_VAL);
    else if (seconds < best->seconds)
      *best = {dt, seconds, table.at(row, "error").number() / length,
               table.at(row, "reference_error").number() / length, best->failed};
  }
  Series series{.label = integrator};
  for (const Best& best : all) {
    if (std::isfinite(best.seconds)) {
      series.add(best.seconds, best.error);
      series.floor.push_back(best.floor);
    } else if (std::isfinite(best.failed)) {
      series.failed_x.push_back(best.failed);
    }
  }
  return series;
}

Panel make_panel(const Table& table, const Scene& scene) {
  std::vector<Series> series;
  for (const IntegratorInfo& method : integrator_list())
    series.push_back(front_of(table, scene.name, method.name));
  return {.title = fmt::format("{}, {:.3g} s", scene.name, scene.end),
          .x = {"time of the step loop [s]", true},
          .y = {"position error / scene length [1]", true},
          .series = with_integrator_looks(std::move(series)),
          .judge_error = scene.judge.error / scene.model.scene_length};
}

// ---- Conclusions, read from the rows

// Row of the cheapest run at least as accurate as `level`; table.rows() if there is none.
std::size_t cheapest(const Table& table, const std::string& scene, double level) {
  std::size_t best = table.rows();
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (table.at(row, "scene").text() != scene || table.at(row, "status").text() != "ok") continue;
    if (!(table.at(row, "error").number() <= level * table.at(row, "scene_length").number())) continue;
    if (best == table.rows() || table.at(row, "seconds").number() < table.at(best, "seconds").number())
      best = row;
  }
  return best;
}

void note_cheapest(Context& context, const Scene& scene) {
  std::string line;
  const Table& table = context.table;
  for (const double level : kLevels) {
    const std::size_t row = cheapest(table, scene.name, level);
    line += fmt::format("{}{:.0e}: ", line.empty() ? "" : "; ", level);
    if (row == table.rows()) {
      line += "none";
      continue;
    }
    const std::string route = table.at(row, "route").text();
    line += fmt::format("{}{} dt {:.2g} s, {:.3g}", table.at(row, "integrator").text(),
                        route == "none" ? "" : "/" + route, table.at(row, "dt").number(),
                        1e3 * table.at(row, "seconds").number() / scene.end);
  }
  context.note(fmt::format(
      "{}, cheapest at errors up to a fraction of the scene's length (ms per simulated second): {}.",
      scene.name, line));
}

void note_left_out(Context& context) {
  const Table& table = context.table;
  std::vector<std::string> words;
  for (const std::string& status : table.distinct("status")) {
    if (status == "ok") continue;
    std::size_t count = 0;
    for (std::size_t row = 0; row < table.rows(); ++row) count += table.at(row, "status").text() == status;
    words.push_back(fmt::format("{} {}", count, status));
  }
  if (!words.empty())
    context.note(fmt::format("Runs without an error to show: {}; the reasons are in the table.",
                             fmt::join(words, ", ")));
  context.note("Left out: hard rows, step-size control, several threads, scenes with bodies and joints.");
}

// Everything is checked before the first step.
void check(const Settings& settings) {
  for (const std::string& spec : settings.texts("scenes")) (void)make_model(spec);
  for (const char* key : {"explicit_fractions", "implicit_rates"})
    for (const double value : settings.numbers(key))
      require_positive(fmt::format("setting '{}'", key), "value", value, "");
  require_positive("setting 'judge_tolerance'", "value", settings.number("judge_tolerance"), "");
  require_positive("setting 'max_seconds'", "value", settings.number("max_seconds"), "s");
}

void body(Context& context) {
  check(context.settings);
  const std::vector<std::string> specs = context.settings.texts("scenes"),
                                 routes = context.settings.texts("routes");
  Chart chart{.name = "work_precision",
              .title = "Error against time",
              .caption =
                  "Each curve is one method, its time step falling from left to right, by its cheapest "
                  "linear route; lower "
                  "left is better, crosses are runs that failed.",
              .grid_columns = specs.size() > 4 ? 3 : 2};
  long total = 0;
  for (const IntegratorInfo& method : integrator_list())
    total += takes_routes(method) ? static_cast<long>(routes.size()) : 1;
  context.progress.start(total * static_cast<long>(specs.size()));
  for (const std::string& spec : specs) {
    if (context.interrupted()) break;
    const Scene scene = make_scene(context, spec);
    if (!scene.judge.status.ok()) continue;
    for (const IntegratorInfo& method : integrator_list())
      for (const std::string& route : takes_routes(method) ? routes : std::vector<std::string>{"none"}) {
        if (context.interrupted()) break;
        study(context, scene, method, route);
        context.progress.advance(fmt::format("{} {} {}", spec, method.name, route));
      }
    chart.panels.push_back(make_panel(context.table, scene));
    note_cheapest(context, scene);
  }
  context.add_chart(std::move(chart));
  note_left_out(context);
}

}  // namespace
}  // namespace feder::experiments

int main(int argc, char** argv) {
  return feder::experiments::run_experiment(feder::experiments::kInfo, argc, argv, feder::experiments::body);
}
