// Do contacts that slide, roll and lean follow their closed forms, and what does the contact law of a step
// cost?
//   accuracy: error at the end of a run against the closed form over dt
//   law:      of the first step of a tower at rest, u = W y + b with the cone conditions of Coulomb's law
//             (solvers/contact/contact_problem.h), from y = 0, without the time for W itself; violation: what
//             is left of the law as a velocity, relative to the largest |b|
#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "engine/check.h"
#include "experiments/support/experiment.h"
#include "experiments/support/measure.h"
#include "experiments/support/timing.h"
#include "models/catalog.h"
#include "models/stack.h"
#include "solvers/reference.h"
#include "solvers/simulate.h"

namespace feder::experiments {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kStep = 1e-3;  // of the towers [s]
constexpr double kGood = 1e-8;  // violation whose price is compared
constexpr double kTightest = 1e-13;
constexpr int kBatch = 20000000;  // entries of W in one timing, at least

const ExperimentInfo kInfo{
    .name = "contacts",
    .question =
        "Do sliding, rolling and leaning contacts converge to their closed forms, at which order, and "
        "what does the direct solve of the contact law cost against projected Gauss-Seidel?",
    .not_modelled = "Impacts located in time, contacts of deforming bodies, the price of finding contacts.",
    .settings = {{"scenes", Kind::kTexts, "incline,rolling_ball,ladder",
                  "incline,incline:speed=-2,rolling_ball,rolling_ball:hollow=0.9,ladder,ladder:angle=0.8",
                  "models with an exact solution and at most one parameter each"},
                 {"dt", Kind::kNumbers, "1e-4:1e-2:5", "1e-5:2e-2:12", "time steps, s"},
                 {"heights", Kind::kNumbers, "1,2,5,10", "1,2,5,10,20,40",
                  "cubes of the towers of equal cubes"},
                 {"ratios", Kind::kNumbers, "1,100,10000", "1e-4,1e-2,1,100,10000",
                  "mass of the top cube over that of the others"},
                 {"ratio_height", Kind::kInteger, "5", "5", "cubes of the towers with a light or heavy top"},
                 {"most_sweeps", Kind::kInteger, "10000", "300000", "of Gauss-Seidel on one tower"},
                 {"repeats", Kind::kInteger, "2", "5", "timings, of which the best counts"}},
    .columns = {"study", "scene", "integrator", "dt", "status", "reason", "steps", "error", "reference_error",
                "seconds", "scene_length", "cubes", "ratio", "contacts", "solver", "newton_iterations",
                "sweeps", "violation"},
    .cases = {"every integrator that sees contacts x scenes x dt", "towers x (direct, sweeps)"}};

Cell cell(double value) {
  return std::isfinite(value) ? Cell(value) : Cell();
}

// ---- Accuracy

void study_accuracy(Context& context, const std::string& spec, const IntegratorInfo& method) {
  const Model model = make_model(spec);
  if (!model.exact)
    throw InputError("setting scenes: got '" + spec + "', expected a model with an exact solution");
  for (const double wanted : context.settings.numbers("dt")) {
    if (context.interrupted()) return;
    const double dt = model.end_time / std::max(1.0, std::round(model.end_time / wanted));
    Integrator integrator = make_integrator(method.name, model.system);
    State state = model.state;
    History history;
    const RunResult run =
        simulate(model.system, integrator, state, history, {.dt = dt, .end_time = model.end_time});
    const double error =
        run.status.ok() ? position_error(model.system, state, model.exact(model.end_time)) : kNone;
    context.table.add({{"study", "accuracy"},
                       {"scene", spec},
                       {"integrator", method.name},
                       {"dt", dt},
                       {"status", to_string(run.status.code)},
                       {"reason", run.status.reason},
                       {"steps", run.steps},
                       {"error", cell(error)},
                       {"reference_error", 0.0},
                       {"seconds", run.seconds},
                       {"scene_length", model.scene_length}});
    context.progress.advance(fmt::format("{} {} {:.2g}", spec, method.name, dt));
  }
}

// ---- The contact law of one step

struct Tower {
  int cubes;
  double ratio;
  ContactProblem problem;
  std::string name() const { return fmt::format("stack:n={},ratio={:g}", cubes, ratio); }
};

Tower make_tower(int cubes, double ratio) {
  const Model model = make_stack({.n = cubes, .ratio = ratio});
  Integrator integrator = make_integrator("implicit_euler_notes", model.system);
  State state = model.state;
  History history;
  const RunResult run = simulate(model.system, integrator, state, history, {.dt = kStep, .end_time = kStep});
  FEDER_CHECK(run.status.ok(), run.status.reason.c_str());
  return {cubes, ratio, std::get<ImplicitEulerNotes>(integrator).contacts()->problem()};
}

using Solver = ContactReport (*)(const ContactProblem&, const ContactOptions&, VectorXd&);

// Seconds of one solve from y = 0; small ones are timed many at a time.
double time_solve(const Tower& tower, Solver solve, const ContactOptions& options, int repeats) {
  const auto once = [&] {
    VectorXd y = VectorXd::Zero(tower.problem.b.size());
    return solve(tower.problem, options, y);
  };
  const ContactReport first = once();
  const double work =
      static_cast<double>(tower.problem.W.size()) *
      (first.sweeps + 1.0 + static_cast<double>(first.newton_iterations) * tower.problem.count());
  const int batch = static_cast<int>(std::max(1.0, std::round(kBatch / work)));
  return best_of(repeats,
                 [&] {
                   const Stopwatch watch;
                   for (int i = 0; i < batch; ++i) (void)once();
                   return watch.seconds();
                 }) /
         batch;
}

void add_law(Context& context, const Tower& tower, const std::string& name, Solver solve,
             const ContactOptions& options) {
  VectorXd y = VectorXd::Zero(tower.problem.b.size());
  const ContactReport report = solve(tower.problem, options, y);
  const bool direct = name == "direct";  // sweeps are stopped on purpose
  const auto repeats = static_cast<int>(context.settings.integer("repeats"));
  const double seconds = time_solve(tower, solve, options, report.sweeps > 1000 ? 1 : repeats);
  context.table.add({{"study", "law"},
                     {"scene", tower.name()},
                     {"dt", kStep},
                     {"status", to_string(direct ? report.status.code : StatusCode::kOk)},
                     {"reason", direct ? report.status.reason : ""},
                     {"seconds", seconds},
                     {"cubes", tower.cubes},
                     {"ratio", tower.ratio},
                     {"contacts", tower.problem.count()},
                     {"solver", name},
                     {"newton_iterations", report.newton_iterations},
                     {"sweeps", report.sweeps},
                     {"violation", report.violation / tower.problem.b.lpNorm<Eigen::Infinity>()}});
}

// 1, 2, 5, 10, ... sweeps, up to where the law holds to rounding.
void study_law(Context& context, const Tower& tower) {
  add_law(context, tower, "direct", solve_contacts, {});  // as a step does it
  const std::int64_t most = context.settings.integer("most_sweeps");
  for (std::int64_t decade = 1; decade <= most; decade *= 10)
    for (const std::int64_t sweeps : {decade, 2 * decade, 5 * decade}) {
      if (sweeps > most || context.interrupted()) return;
      add_law(context, tower, "sweeps", solve_by_sweeps,
              {.tolerance = kTightest, .most_sweeps = static_cast<int>(sweeps)});
      if (context.table.at(context.table.rows() - 1, "sweeps").number() < static_cast<double>(sweeps)) return;
    }
}

// ---- Charts

Chart accuracy_chart(const Table& table) {
  Chart chart{.name = "contacts",
              .title = "Contacts against their closed forms",
              .caption = "Error at the end of a run over the time step: first order, as the method is.",
              .grid_columns = 3};
  for (const std::string& scene : table.distinct("scene")) {
    const auto keep = [&](std::size_t row) {
      return table.at(row, "study").text() == "accuracy" && table.at(row, "scene").text() == scene;
    };
    std::vector<Series> series = with_integrator_looks(series_by(table, "integrator", "dt", "error", keep));
    if (series.empty()) continue;
    chart.panels.push_back({.title = scene,
                            .x = {.label = "time step dt [s]", .log = true},
                            .y = {.label = "position error at the end [m]", .log = true},
                            .series = std::move(series),
                            .slopes = {{1.0}}});
  }
  return chart;
}

// What one solver reached on one tower, in the order of the rows.
struct Curve {
  int cubes = 0;
  double ratio = 0.0;
  std::string solver = "";
  std::vector<double> seconds = {}, newton = {}, sweeps = {}, violation = {};

  /// Seconds until the violation is kGood; NaN if never.
  double price() const {
    for (std::size_t i = 0; i < violation.size(); ++i)
      if (violation[i] <= kGood) return seconds[i];
    return kNone;
  }
};

std::vector<Curve> curves_of(const Table& table) {
  std::vector<Curve> all;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (table.at(row, "study").text() != "law") continue;
    const auto cubes = static_cast<int>(table.at(row, "cubes").number());
    const double ratio = table.at(row, "ratio").number();
    const std::string solver = table.at(row, "solver").text();
    if (all.empty() || all.back().cubes != cubes || all.back().ratio != ratio || all.back().solver != solver)
      all.push_back({cubes, ratio, solver});
    all.back().seconds.push_back(table.at(row, "seconds").number());
    all.back().newton.push_back(table.at(row, "newton_iterations").number());
    all.back().sweeps.push_back(table.at(row, "sweeps").number());
    all.back().violation.push_back(std::max(table.at(row, "violation").number(), 1e-17));
  }
  return all;
}

// One panel per tower, the direct solve beside the sweeps, and the prices of all.
Chart law_chart(const Context& context) {
  Chart chart{.name = "contacts_law",
              .title = "The contact law of one step, direct and by Gauss-Seidel",
              .caption =
                  "What is left of the contact law over the time spent on it, per tower of cubes; last, the "
                  "time to a violation of 1e-8 on equal cubes.",
              .grid_columns = 3};
  Series direct{.label = "direct", .look = 0}, sweeps{.label = "Gauss-Seidel", .look = 1};
  Panel prices{.title = fmt::format("equal cubes, to a violation of {:.0e}", kGood),
               .x = {.label = "cubes [1]", .log = true},
               .y = {.label = "time of a solve [s]", .log = true},
               .series = {direct, sweeps}};
  for (const Curve& curve : curves_of(context.table)) {
    const bool is_direct = curve.solver == "direct";
    const std::string title =
        curve.ratio == 1.0 ? fmt::format("{} cubes", curve.cubes)
                           : fmt::format("{} cubes, top {:g} times as heavy", curve.cubes, curve.ratio);
    if (chart.panels.empty() || chart.panels.back().title != title)
      chart.panels.push_back(
          {.title = title,
           .x = {.label = "time of a solve [s]", .log = true},
           .y = {.label = "violation / largest |b| [1]", .log = true, .min = 1e-17, .max = 10.0}});
    Series series = is_direct ? direct : sweeps;
    series.x = curve.seconds, series.y = curve.violation;
    series.markers = is_direct, series.line = !is_direct;
    chart.panels.back().series.push_back(std::move(series));
    if (curve.ratio == 1.0 && std::isfinite(curve.price()))
      prices.series[is_direct ? 0 : 1].add(curve.cubes, curve.price());
  }
  chart.panels.push_back(std::move(prices));
  return chart;
}

// ---- Conclusions

void note_orders(Context& context) {
  const Table& table = context.table;
  for (const std::string& scene : table.distinct("scene")) {
    std::string line;
    for (const std::string& method : table.distinct("integrator")) {
      std::vector<double> dt, error, relative;
      for (std::size_t row = 0; row < table.rows(); ++row)
        if (table.at(row, "study").text() == "accuracy" && table.at(row, "scene").text() == scene &&
            table.at(row, "integrator").text() == method && table.at(row, "error").number() > 0.0) {
          dt.push_back(table.at(row, "dt").number());
          error.push_back(table.at(row, "error").number());
        }
      if (dt.size() < 2) continue;
      const auto finest = static_cast<std::size_t>(std::min_element(dt.begin(), dt.end()) - dt.begin());
      line += fmt::format("{}{}: order {:.2f}, {:.1e} m at dt {:.1e} s", line.empty() ? "" : "; ", method,
                          fit_power(dt, error).slope, error[finest], dt[finest]);
    }
    if (!line.empty()) context.note(fmt::format("{}, {}.", scene, line));
  }
}

void note_prices(Context& context) {
  const std::vector<Curve> curves = curves_of(context.table);
  for (std::size_t i = 0; i + 1 < curves.size(); ++i) {
    const Curve &direct = curves[i], &sweeps = curves[i + 1];
    if (direct.solver != "direct" || sweeps.solver != "sweeps") continue;
    const std::string rival =
        std::isfinite(sweeps.price())
            ? fmt::format("sweeps take {:.3g} times as long to {:.0e}", sweeps.price() / direct.seconds[0],
                          kGood)
            : fmt::format("{:.0f} sweeps leave {:.1e}, after {:.3g} times as long", sweeps.sweeps.back(),
                          sweeps.violation.back(), sweeps.seconds.back() / direct.seconds[0]);
    context.note(fmt::format(
        "{} cubes, mass ratio of the top {:g}: direct, {:.0f} iterations and {:.0f} sweeps to {:.1e}; {}.",
        direct.cubes, direct.ratio, direct.newton[0], direct.sweeps[0], direct.violation[0], rival));
  }
}

void body(Context& context) {
  std::vector<IntegratorInfo> methods;
  for (const IntegratorInfo& each : integrator_list())
    if (each.contacts) methods.push_back(each);
  const std::vector<std::string> scenes = context.settings.texts("scenes");
  std::vector<std::pair<int, double>> towers;
  for (const double n : context.settings.numbers("heights")) towers.emplace_back(static_cast<int>(n), 1.0);
  const auto height = static_cast<int>(context.settings.integer("ratio_height"));
  for (const double ratio : context.settings.numbers("ratios"))
    if (ratio != 1.0) towers.emplace_back(height, ratio);

  context.progress.start(static_cast<long>(
      methods.size() * scenes.size() * context.settings.numbers("dt").size() + towers.size()));
  for (const std::string& scene : scenes)
    for (const IntegratorInfo& method : methods) study_accuracy(context, scene, method);
  for (const auto& [cubes, ratio] : towers) {
    if (context.interrupted()) break;
    study_law(context, make_tower(cubes, ratio));
    context.progress.advance(fmt::format("{} cubes, {:g}", cubes, ratio));
  }
  context.add_chart(accuracy_chart(context.table));
  context.add_chart(law_chart(context));
  note_orders(context);
  note_prices(context);
}

}  // namespace
}  // namespace feder::experiments

int main(int argc, char** argv) {
  return feder::experiments::run_experiment(feder::experiments::kInfo, argc, argv, feder::experiments::body);
}
