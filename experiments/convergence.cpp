// Does every integrator converge at its order, and does step-size control keep its promise?
//   fixed steps: error at the end against dt; order = slope on log-log axes, fitted to the finest points
//   above rounding and the judge's own error step doubling (notes B4): error at the end against the
//   tolerance; slope 1 if proportional
#include <fmt/format.h>

#include <cmath>
#include <set>

#include "engine/check.h"
#include "experiments/support/experiment.h"
#include "experiments/support/measure.h"
#include "models/catalog.h"
#include "solvers/reference.h"
#include "solvers/simulate.h"

namespace feder::experiments {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kFitPoints = 3;    // finest points of a fit
constexpr int kTolerancePeriods = 2;     // enough steps for the controller to settle
constexpr double kOrderBound = 0.05;     // distance from the order that is called agreement
constexpr double kToleranceBound = 0.1;  // and from proportionality

const ExperimentInfo kInfo{
    .name = "convergence",
    .question =
        "Does every integrator converge at its order, and is the error of step doubling proportional "
        "to its tolerance?",
    .not_modelled = "Scenes with impacts or switches, where smoothness limits the order.",
    .settings =
        {{"scenes", Kind::kTexts,
          "oscillator,damped_oscillator,chain,pendulum:angle=1.5,spring_pendulum:stiffness=300",
          "oscillator,damped_oscillator,chain,pendulum:angle=1.5,pendulum:angle=2,spring_pendulum:stiffness="
          "300",
          "models with at most one parameter each"},
         {"steps_order_1", Kind::kNumbers, "500:16000:6", "500:256000:10", "steps of first-order methods"},
         {"steps_order_2", Kind::kNumbers, "64:4096:7", "32:32768:11", "steps of second-order methods"},
         {"steps_order_4", Kind::kNumbers, "32:2048:7", "16:4096:9", "steps of methods of higher order"},
         {"tolerance_scenes", Kind::kTexts, "spring_pendulum:stiffness=300",
          "spring_pendulum:stiffness=300,chain,oscillator,spring_pendulum", "scenes of step doubling"},
         {"tolerances", Kind::kNumbers, "1e-9:1e-3:7", "1e-9:1e-3:19",
          "local error per step allowed by step doubling, fraction of the scene's length"}},
    .columns = {"scene", "integrator", "route", "order", "control", "dt", "tolerance", "status", "reason",
                "steps", "error", "reference_error", "scene_length", "slope", "fitted_slope", "seconds"},
    .cases = {"every integrator x scenes x steps", "every integrator x tolerance_scenes x tolerances"}};

// ---- One scene and its true end state

struct Scene {
  std::string name;
  Model model;
  double end = 0.0;    // [s]
  State truth;         // at the end
  double doubt = 0.0;  // of the truth [m]
  bool judged = true;
};

// The exact solution, or else the judge at its tightest.
Scene make_scene(Context& context, const std::string& spec, int whole_periods) {
  Scene scene{spec, make_model(spec), 0.0, {}, 0.0, true};
  const Model& model = scene.model;
  scene.end = observation_time(model, whole_periods);
  if (model.exact) {
    scene.truth = model.exact(scene.end);
    scene.doubt = std::numeric_limits<double>::epsilon() * model.scene_length;
    return scene;
  }
  ReferenceOptions options;
  options.judge = {.relative_tolerance = 1e-13, .position_tolerance = 1e-15, .velocity_tolerance = 1e-14};
  const Reference judge = make_reference(model.system, model.state, scene.end, options);
  scene.judged = judge.status.ok();
  if (!scene.judged)
    context.fail(Status::failure(judge.status.code, "the judge on " + spec + ": " + judge.status.reason));
  scene.truth = judge.state;
  scene.doubt = judge.error;
  return scene;
}

// Error below which rounding of the steps or the truth itself decide.
double floor_of(const Scene& scene, double steps) {
  const double rounding = std::numeric_limits<double>::epsilon() * scene.model.scene_length;
  return 10.0 * scene.doubt + 30.0 * rounding * std::sqrt(steps);
}

// ---- Runs of one integrator on one scene

struct Point {
  double x = 0.0;  // dt or tolerance
  double steps = 0.0, error = kNone, seconds = 0.0;
  Status status;
};

Point run_fixed(const Scene& scene, const std::string& name, std::int64_t steps) {
  Integrator integrator = make_integrator(name, scene.model.system);
  State state = scene.model.state;
  History history;
  RunOptions options;
  options.dt = scene.end / static_cast<double>(steps);
  options.end_time = scene.end;
  RunResult run = simulate(scene.model.system, integrator, state, history, options);
  Point point{options.dt, static_cast<double>(run.steps), kNone, run.seconds, std::move(run.status)};
  if (point.status.ok()) point.error = position_error(scene.model.system, state, scene.truth);
  return point;
}

Point run_doubling(const Scene& scene, const std::string& name, double tolerance) {
  Integrator integrator = make_integrator(name, scene.model.system);
  State state = scene.model.state;
  History history;
  AdaptiveOptions options;
  options.tolerance = tolerance * scene.model.scene_length;
  options.first_dt = 1e-3 * scene.end;
  options.end_time = scene.end;
  AdaptiveResult run = simulate_adaptive(scene.model.system, integrator, state, history, options);
  Point point{tolerance, static_cast<double>(run.accepted + run.rejected), kNone, run.seconds,
              std::move(run.status)};
  if (point.status.ok()) point.error = position_error(scene.model.system, state, scene.truth);
  return point;
}

// ---- Slopes

bool counts(const Scene& scene, const Point& point) {
  return point.status.ok() && point.error > floor_of(scene, point.steps);
}

// Slope between a point and the one before it.
double pair_slope(const std::vector<Point>& points, std::size_t i) {
  if (i == 0 || !points[i].status.ok() || !points[i - 1].status.ok()) return kNone;
  return std::log(points[i].error / points[i - 1].error) / std::log(points[i].x / points[i - 1].x);
}

// Fit to the last `most` points above the floor.
double fitted_slope(const Scene& scene, const std::vector<Point>& points, std::size_t most) {
  std::vector<double> x, y;
  for (auto point = points.rbegin(); point != points.rend() && x.size() < most; ++point)
    if (counts(scene, *point)) x.push_back(point->x), y.push_back(point->error);
  return fit_power(x, y).slope;
}

Cell number_or_empty(double value) {
  return std::isfinite(value) ? Cell(value) : Cell();
}

void add_rows(Context& context, const Scene& scene, const IntegratorInfo& method, const char* control,
              const std::vector<Point>& points, double fitted) {
  const std::string x = std::string_view(control) == "fixed" ? "dt" : "tolerance";
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point& p = points[i];
    context.table.add({{"scene", scene.name},
                       {"integrator", method.name},
                       {"route", takes_routes(method) ? "auto" : "none"},
                       {"order", method.order},
                       {"control", control},
                       {x, p.x},
                       {"status", to_string(p.status.code)},
                       {"reason", p.status.reason},
                       {"steps", static_cast<std::int64_t>(p.steps)},
                       {"error", number_or_empty(p.error)},
                       {"reference_error", scene.doubt},
                       {"scene_length", scene.model.scene_length},
                       {"slope", number_or_empty(pair_slope(points, i))},
                       {"fitted_slope", number_or_empty(fitted)},
                       {"seconds", p.seconds}});
  }
}

// ---- The two questions

struct Fit {
  std::string scene, integrator;
  double wanted, slope, bound;
};

std::vector<double> steps_for(const Settings& settings, int order) {
  return settings.numbers(order == 1 ? "steps_order_1" : order == 2 ? "steps_order_2" : "steps_order_4");
}

template <class Run>
std::vector<Point> run_all(Context& context, const std::vector<double>& places, Run&& run) {
  std::vector<Point> points;
  for (const double place : places) {
    if (context.interrupted()) break;
    points.push_back(run(place));
    if (points.back().status.code == StatusCode::kRefused) break;  // would be refused at every place
  }
  return points;
}

void study_steps(Context& context, const Scene& scene, const IntegratorInfo& method, std::vector<Fit>& fits) {
  const auto points = run_all(context, steps_for(context.settings, method.order), [&](double steps) {
    return run_fixed(scene, method.name, std::llround(steps));
  });
  const double fitted = fitted_slope(scene, points, kFitPoints);
  add_rows(context, scene, method, "fixed", points, fitted);
  if (std::isfinite(fitted))
    fits.push_back({scene.name, method.name, 1.0 * method.order, fitted, kOrderBound});
}

void study_tolerance(Context& context, const Scene& scene, const IntegratorInfo& method,
                     std::vector<Fit>& fits) {
  const std::vector<double> tolerances = context.settings.numbers("tolerances");
  const auto points = run_all(context, tolerances,
                              [&](double tolerance) { return run_doubling(scene, method.name, tolerance); });
  const double fitted = fitted_slope(scene, points, tolerances.size());
  add_rows(context, scene, method, "doubling", points, fitted);
  if (std::isfinite(fitted)) fits.push_back({scene.name, method.name, 1.0, fitted, kToleranceBound});
}

// ---- Charts and conclusions

// The slopes that the methods of a panel promise.
std::set<double> promised_slopes(bool fixed, const std::vector<Series>& methods) {
  std::set<double> slopes;
  for (const Series& series : methods)
    slopes.insert(fixed ? integrator_list().at(series.look.value()).order : 1.0);
  return slopes;
}

void add_chart(Context& context, const std::string& control, const std::vector<Scene>& scenes) {
  const bool fixed = control == "fixed";
  const Table& table = context.table;
  Chart chart{.name = fixed ? "convergence" : "convergence_tolerance",
              .title = fixed ? "Error against time step" : "Error against tolerance of step doubling",
              .caption = fixed
                             ? "Each method falls along the slope of its order until rounding or the judge's "
                               "own error stop it."
                             : "The error at the end is proportional to the tolerance, whatever the order.",
              .grid_columns = fixed ? 3 : 2};
  for (const Scene& scene : scenes) {
    const auto keep = [&](std::size_t row) {
      return table.at(row, "scene").text() == scene.name && table.at(row, "control").text() == control &&
             table.at(row, "status").text() != "refused";
    };
    Panel panel{.title = scene.name,
                .x = {fixed ? "time step dt [s]" : "tolerance [1, of the scene's length]", true},
                .y = {"position error at the end [m]", true},
                .series = with_integrator_looks(
                    series_by(table, "integrator", fixed ? "dt" : "tolerance", "error", keep))};
    if (!scene.model.exact) panel.judge_error = scene.doubt;
    for (const double slope : promised_slopes(fixed, panel.series)) panel.slopes.push_back({slope});
    chart.panels.push_back(std::move(panel));
  }
  context.add_chart(std::move(chart));
}

// "explicit_euler 0.99..1.01, ..." over the scenes, and what lies outside.
void note_fits(Context& context, const std::string& what, const std::vector<Fit>& fits) {
  std::string line, outside;
  for (const IntegratorInfo& method : integrator_list()) {
    double least = HUGE_VAL, largest = -HUGE_VAL;
    for (const Fit& fit : fits)
      if (fit.integrator == method.name) {
        least = std::min(least, fit.slope), largest = std::max(largest, fit.slope);
        if (std::abs(fit.slope - fit.wanted) > fit.bound)
          outside += fmt::format("{}{} on {} ({:.3f})", outside.empty() ? "" : ", ", method.name, fit.scene,
                                 fit.slope);
      }
    if (least <= largest)
      line += fmt::format("{}{} {:.3f}..{:.3f}", line.empty() ? "" : ", ", method.name, least, largest);
  }
  if (line.empty()) return;
  context.note(fmt::format("{}: {}; {}.", what, line,
                           outside.empty() ? fmt::format("all within {} of the expected slope", fits[0].bound)
                                           : fmt::format("outside {}: {}", fits[0].bound, outside)));
}

void note_refusals(Context& context) {
  const Table& table = context.table;
  for (const std::string& scene : table.distinct("scene")) {
    std::string names;
    for (std::size_t row = 0; row < table.rows(); ++row)
      if (table.at(row, "scene").text() == scene && table.at(row, "status").text() == "refused" &&
          table.at(row, "control").text() == "fixed")
        names += (names.empty() ? "" : ", ") + table.at(row, "integrator").text();
    if (!names.empty()) context.note(fmt::format("{} refused: {} (hard rows).", scene, names));
  }
}

template <class Study>
void study(Context& context, const std::string& key, const std::string& control, const std::string& what,
           int whole_periods, Study&& one) {
  std::vector<Scene> scenes;
  std::vector<Fit> fits;
  for (const std::string& spec : context.settings.texts(key)) {
    Scene scene = make_scene(context, spec, whole_periods);
    if (!scene.judged) continue;
    scenes.push_back(std::move(scene));
    for (const IntegratorInfo& method : integrator_list()) {
      if (context.interrupted()) break;
      one(context, scenes.back(), method, fits);
      context.progress.advance(spec + " " + method.name);
    }
  }
  add_chart(context, control, scenes);
  note_fits(context, what, fits);
}

// Everything is checked before the first step.
void check(const Settings& settings) {
  for (const char* key : {"scenes", "tolerance_scenes"})
    for (const std::string& spec : settings.texts(key)) (void)make_model(spec);
  for (const double tolerance : settings.numbers("tolerances"))
    require_positive("setting 'tolerances'", "tolerance", tolerance, "");
  for (const char* key : {"steps_order_1", "steps_order_2", "steps_order_4"})
    for (const double steps : settings.numbers(key))
      if (!(steps >= 1.0 && steps <= 1e12))
        fail_input(fmt::format("setting '{}'", key), "steps", steps, "", "1 to 1e12");
}

void body(Context& context) {
  check(context.settings);
  const std::size_t methods = integrator_list().size();
  context.progress.start(static_cast<long>(methods * (context.settings.texts("scenes").size() +
                                                      context.settings.texts("tolerance_scenes").size())));
  study(context, "scenes", "fixed", "Fitted order over the scenes", 0, study_steps);
  study(context, "tolerance_scenes", "doubling", "Fitted slope of error against tolerance", kTolerancePeriods,
        study_tolerance);
  note_refusals(context);
}

}  // namespace
}  // namespace feder::experiments

int main(int argc, char** argv) {
  return feder::experiments::run_experiment(feder::experiments::kInfo, argc, argv, feder::experiments::body);
}
