// Sweeps over the rows or a factorisation: what does either buy?
//   error:     position error against the judge at the scene's end, in steps of a frame (1/60 s) or parts of
//              it; violation: largest |phi| of all rows there, over the scene's length
//   stiffness: stretch of a chain at rest under its weight by its springs, over that under the sweeps
//   distance:  of converged sweeps from the linearised and the converged implicit step over dt (notes H6)
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "experiments/support/experiment.h"
#include "experiments/support/measure.h"
#include "experiments/support/timing.h"
#include "models/catalog.h"
#include "models/hanging_chain.h"
#include "solvers/reference.h"
#include "solvers/simulate.h"

namespace feder::experiments {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kFrame = 1.0 / 60.0;  // [s]
constexpr int kConverged = 20000;      // sweeps at most, where they do not end by themselves

const ExperimentInfo kInfo{
    .name = "iterative_vs_direct",
    .question =
        "What do sweeps over the rows (position based dynamics) give for the time they take, beside the "
        "direct routes, over stiffness, length and mass ratio?",
    .not_modelled = "Contacts, several threads, multigrid and other accelerations of the sweeps.",
    .settings =
        {{"scenes", Kind::kTexts, "S1(20):stiffness=1e4,S1(20),S1h(20),S1h(20):load=1,S1(100),S3c(20)",
          "S1(20):stiffness=1e4,S1(20),S1h(20),S1h(20):load=1,S1(100),S1h(100),S3c(20),S3c(100),S2(20)",
          "models with at most one parameter each"},
         {"counts", Kind::kNumbers, "1,5,20,100", "1,2,5,10,20,50,100,200",
          "sweeps per frame, or substeps per frame"},
         {"lengths", Kind::kNumbers, "10,30", "10,30,100", "masses of the chain at rest"},
         {"sweeps", Kind::kNumbers, "1,3,10,30,100,300", "1,3,10,30,100,300,1000,3000",
          "of the chain at rest"},
         {"distance_scenes", Kind::kTexts, "S1(10),S2(5),S3c(5)", "S1(20),S2(8),S3c(10)",
          "models with at most one parameter each"},
         {"halvings", Kind::kInteger, "4", "7", "of the frame, for the distance"},
         {"judge_tolerance", Kind::kNumber, "1e-9", "1e-11", "relative tolerance of the judge"},
         {"repeats", Kind::kInteger, "2", "5", "timings of a run, of which the best counts"}},
    .columns = {"study", "scene", "method", "integrator", "route", "dt", "sweeps", "substeps", "status",
                "reason", "steps", "error", "reference_error", "violation", "seconds", "scene_length",
                "links", "stiffness_ratio", "distance"},
    .cases = {"sweeps, substeps, implicit_euler_notes, implicit_euler_newton x scenes x counts",
              "chains at rest x sweeps", "distance from both implicit steps x dt"}};

Cell cell(double value) {
  return std::isfinite(value) ? Cell(value) : Cell();
}

// ---- Error against time

struct Scene {
  std::string name;
  Model model;
  Reference judge;
};

Scene make_scene(Context& context, const std::string& spec) {
  Scene scene{spec, make_model(spec), {}};
  const double tolerance = context.settings.number("judge_tolerance");
  ReferenceOptions options;
  options.judge.relative_tolerance = tolerance;
  options.judge.position_tolerance = 1e-2 * tolerance;
  options.judge.velocity_tolerance = 1e-1 * tolerance;
  scene.judge = make_reference(scene.model.system, scene.model.state, scene.model.end_time, options);
  const Status& status = scene.judge.status;
  if (!status.ok())
    context.fail(Status::failure(status.code, "the judge on " + spec + ": " + status.reason));
  else
    context.note(
        fmt::format("Judge of {}: {}, own error {:.1e} m.", spec, scene.judge.method, scene.judge.error));
  return scene;
}

// A way to spend `count` units of work on a frame.
struct Way {
  const char* name;
  const char* integrator;
  bool substeps;
};
constexpr Way kWays[] = {{"sweeps", "xpbd", false},
                         {"substeps of one sweep", "xpbd", true},
                         {"direct, one linearisation", "implicit_euler_notes", true},
                         {"direct, Newton", "implicit_euler_newton", true}};

double violation(const Model& model, const State& state) {
  VectorXd phi;
  evaluate_phi(model.system, state.q, phi);
  return phi.lpNorm<Eigen::Infinity>() / model.scene_length;
}

void study_error(Context& context, const Scene& scene, const Way& way, int count) {
  const System& system = scene.model.system;
  const bool swept = std::string(way.integrator) == "xpbd";
  IntegratorOptions options;
  options.sweeps = swept && !way.substeps ? count : 1;
  options.substeps = swept && way.substeps ? count : 1;
  const double dt = swept || !way.substeps ? kFrame : kFrame / count;
  State state;
  RunResult run;
  std::string route = "none";
  const double seconds = best_of(static_cast<int>(context.settings.integer("repeats")), [&] {
    Integrator integrator = make_integrator(way.integrator, system, options);
    History history;
    state = scene.model.state;
    run = simulate(system, integrator, state, history, {.dt = dt, .end_time = scene.model.end_time});
    if (const LinearSolver* solver = linear_solver(integrator)) route = solver->route_name();
    return run.seconds;
  });
  const bool ok = run.status.ok() && scene.judge.status.ok();
  context.table.add({{"study", "error"},
                     {"scene", scene.name},
                     {"method", way.name},
                     {"integrator", way.integrator},
                     {"route", route},
                     {"dt", dt},
                     {"sweeps", cell(swept ? options.sweeps : kNone)},
                     {"substeps", way.substeps ? count : 1},
                     {"status", to_string(run.status.code)},
                     {"reason", run.status.reason},
                     {"steps", run.steps},
                     {"error", ok ? cell(position_error(system, state, scene.judge.state)) : Cell()},
                     {"reference_error", scene.judge.error},
                     {"violation", ok ? cell(violation(scene.model, state)) : Cell()},
                     {"seconds", seconds},
                     {"scene_length", scene.model.scene_length}});
}

// ---- Effective stiffness

// A chain let down from its rest lengths and braked until it hangs still.
void study_stiffness(Context& context, int links, int sweeps) {
  constexpr double kEnd = 40.0, kStiffness = 1e5;
  const HangingChain chain{.n = links,
                           .mass = 1.0 / links,
                           .stiffness = kStiffness,
                           .link = 1.0 / links,
                           .drag = 1.0 / links,
                           .angle = 0.5 * std::numbers::pi};
  const Model model = make_hanging_chain(chain);
  Integrator xpbd = make_integrator("xpbd", model.system, {.sweeps = sweeps});
  State state = model.state;
  History history;
  const RunResult run = simulate(model.system, xpbd, state, history, {.dt = kFrame, .end_time = kEnd});
  // sum of i m g / d over the links
  const double expected = chain.mass * chain.gravity * 0.5 * links * (links + 1.0) / kStiffness;
  const double measured = -state.q[3 * links + 1] - 1.0;
  context.table.add({{"study", "stiffness"},
                     {"scene", fmt::format("{} links", links)},
                     {"integrator", "xpbd"},
                     {"dt", kFrame},
                     {"sweeps", sweeps},
                     {"substeps", 1},
                     {"status", to_string(run.status.code)},
                     {"reason", run.status.reason},
                     {"steps", run.steps},
                     {"links", links},
                     {"stiffness_ratio", run.status.ok() ? cell(expected / measured) : Cell()},
                     {"seconds", run.seconds}});
}

// ---- Distance from the implicit steps

State end_of(const Model& model, const char* integrator, double dt, const IntegratorOptions& options,
             Status& status) {
  Integrator method = make_integrator(integrator, model.system, options);
  State state = model.state;
  History history;
  status = simulate(model.system, method, state, history, {.dt = dt, .end_time = 6.0 * kFrame}).status;
  return state;
}

void study_distance(Context& context, const std::string& spec, double dt) {
  const Model model = make_model(spec);
  Status newton_status;
  const State newton = end_of(model, "implicit_euler_newton", dt, {}, newton_status);
  const double moved = position_error(model.system, newton, model.state);
  struct Rival {
    const char *name, *integrator;
    IntegratorOptions options;
  };
  for (const Rival& rival :
       {Rival{"converged sweeps, J updated", "xpbd", {.sweeps = kConverged}},
        Rival{"converged sweeps, J frozen", "xpbd", {.sweeps = kConverged, .frozen_rows = true}},
        Rival{"one linearisation", "implicit_euler_notes", {}}}) {
    Status status;
    const State end = end_of(model, rival.integrator, dt, rival.options, status);
    const bool ok = status.ok() && newton_status.ok();
    context.table.add({{"study", "distance"},
                       {"scene", spec},
                       {"method", rival.name},
                       {"integrator", rival.integrator},
                       {"dt", dt},
                       {"status", to_string(status.code)},
                       {"reason", status.reason},
                       {"distance", ok ? cell(position_error(model.system, end, newton) / moved) : Cell()}});
  }
}

// ---- Charts

Chart error_chart(const Context& context, const std::vector<Scene>& scenes, const char* column) {
  const Table& table = context.table;
  const bool error = std::string(column) == "error";
  Chart chart{
      .name = error ? "iterative_vs_direct" : "iterative_vs_direct_rows",
      .title = fmt::format("{} against time, {} sweeps or substeps in a frame of 1/60 s",
                           error ? "Error" : "What is left of the rows",
                           context.settings.values().find("counts")->second),
      .caption =
          error ? "Position error at the end (0.25 s) against the time of the run; along a curve the sweeps "
                  "or substeps per frame grow."
                : "Largest |phi| at the end over the scene's length; a spring's own stretch counts.",
      .grid_columns = 3};
  for (const Scene& scene : scenes) {
    const auto keep = [&](std::size_t row) {
      return table.at(row, "study").text() == "error" && table.at(row, "scene").text() == scene.name;
    };
    std::vector<Series> series = series_by(table, "method", "seconds", column, keep);
    for (Series& each : series)
      for (std::size_t i = 0; i < std::size(kWays); ++i)
        if (each.label == kWays[i].name) each.look = i;
    Panel panel{.title = scene.name,
                .x = {.label = "time of the run [s]", .log = true},
                .y = {.label = error ? "position error at the end [m]" : "largest |phi| / scene length [1]",
                      .log = true},
                .series = std::move(series)};
    if (error) panel.judge_error = scene.judge.error;
    chart.panels.push_back(std::move(panel));
  }
  return chart;
}

Chart stiffness_chart(const Table& table) {
  const auto keep = [&](std::size_t row) { return table.at(row, "study").text() == "stiffness"; };
  return {.name = "iterative_vs_direct_stiffness",
          .title = "How stiff springs are under sweeps",
          .caption =
              "A chain of 1 kg and 1 m at rest under its weight, springs of 1e5 N/m, steps of 1/60 s: its "
              "stiffness over that of its springs.",
          .panels = {{.x = {.label = "sweeps per step [1]", .log = true},
                      .y = {.label = "effective stiffness / stiffness [1]", .log = true, .max = 2.0},
                      .series = series_by(table, "scene", "sweeps", "stiffness_ratio", keep),
                      .marks = {{.at = 1.0, .label = "direct", .vertical = false}}}},
          .grid_columns = 1};
}

Chart distance_chart(const Table& table) {
  Chart chart{.name = "iterative_vs_direct_distance",
              .title = "Converged sweeps beside the converged implicit step",
              .caption =
                  "Distance of the places after 0.1 s from Newton's, over the way moved: with J frozen the "
                  "sweeps are the linearised step, with J updated they are a third method.",
              .grid_columns = 3};
  std::vector<std::string> scenes;
  for (std::size_t row = 0; row < table.rows(); ++row)
    if (table.at(row, "study").text() == "distance" &&
        std::find(scenes.begin(), scenes.end(), table.at(row, "scene").text()) == scenes.end())
      scenes.push_back(table.at(row, "scene").text());
  for (const std::string& scene : scenes)
    chart.panels.push_back({.title = scene,
                            .x = {.label = "time step dt [s]", .log = true},
                            .y = {.label = "distance / way [1]", .log = true},
                            .series = series_by(table, "method", "dt", "distance",
                                                [&](std::size_t row) {
                                                  return table.at(row, "study").text() == "distance" &&
                                                         table.at(row, "scene").text() == scene;
                                                }),
                            .slopes = {{1.0}, {2.0}}});
  return chart;
}

// ---- Conclusions

// The run of least error of each way, and its time.
void note_errors(Context& context, const Scene& scene) {
  const Table& table = context.table;
  std::string line;
  for (const Way& way : kWays) {
    double best = HUGE_VAL, seconds = kNone;
    for (std::size_t row = 0; row < table.rows(); ++row)
      if (table.at(row, "study").text() == "error" && table.at(row, "scene").text() == scene.name &&
          table.at(row, "method").text() == way.name && table.at(row, "error").number() < best) {
        best = table.at(row, "error").number();
        seconds = table.at(row, "seconds").number();
      }
    if (std::isfinite(best))
      line +=
          fmt::format("{}{} {:.1e} m in {:.2g} ms", line.empty() ? "" : "; ", way.name, best, 1e3 * seconds);
  }
  context.note(fmt::format("{}, least error: {}.", scene.name, line));
}

void body(Context& context) {
  const std::vector<double> counts = context.settings.numbers("counts"),
                            lengths = context.settings.numbers("lengths"),
                            sweeps = context.settings.numbers("sweeps");
  const std::vector<std::string> scenes = context.settings.texts("scenes"),
                                 distances = context.settings.texts("distance_scenes");
  const auto halvings = static_cast<int>(context.settings.integer("halvings"));
  context.progress.start(static_cast<long>(scenes.size() * std::size(kWays) * counts.size() +
                                           lengths.size() * sweeps.size() +
                                           distances.size() * (halvings + 1u)));
  std::vector<Scene> made;
  for (const std::string& spec : scenes) {
    if (context.interrupted()) return;
    made.push_back(make_scene(context, spec));
    for (const Way& way : kWays)
      for (const double count : counts) {
        if (context.interrupted()) return;
        study_error(context, made.back(), way, static_cast<int>(count));
        context.progress.advance(spec + " " + way.name);
      }
    note_errors(context, made.back());
  }
  for (const double links : lengths)
    for (const double count : sweeps) {
      if (context.interrupted()) return;
      study_stiffness(context, static_cast<int>(links), static_cast<int>(count));
      context.progress.advance("chain at rest");
    }
  for (const std::string& spec : distances)
    for (int i = 0; i <= halvings; ++i) {
      if (context.interrupted()) return;
      study_distance(context, spec, std::ldexp(kFrame, -i));
      context.progress.advance(spec + " distance");
    }
  context.add_chart(error_chart(context, made, "error"));
  context.add_chart(error_chart(context, made, "violation"));
  context.add_chart(stiffness_chart(context.table));
  context.add_chart(distance_chart(context.table));
}

}  // namespace
}  // namespace feder::experiments

int main(int argc, char** argv) {
  return feder::experiments::run_experiment(feder::experiments::kInfo, argc, argv, feder::experiments::body);
}
