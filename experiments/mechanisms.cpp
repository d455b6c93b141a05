// What does each integrator make of hinged mechanisms with hard, partly redundant rows?
//   accuracy:      error at the end against the judge over dt and over seconds; one run measures, others are
//                  timed without an observer
//   gap:           largest |phi| of a hard row over the run; velocity gap: largest |J v + phi_t|, in the
//   rows'
//                  own units (m or 1, per second)
//   change point:  a parallelogram that folds flat at the crank angle pi, where its rows lose one more rank
//                  and two motions go on: as a parallelogram, or crossed. The start angles differ by more
//                  than a step, so that steps end at every distance from the flat pose.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "engine/check.h"
#include "experiments/support/experiment.h"
#include "experiments/support/measure.h"
#include "experiments/support/timing.h"
#include "models/catalog.h"
#include "models/four_bar.h"
#include "solvers/reference.h"
#include "solvers/simulate.h"

namespace feder::experiments {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kLevels[] = {1e-2, 1e-4, 1e-6};  // of the scene's length
constexpr double kPassageTime = 0.35;             // [s]
constexpr double kPassageSeconds = 60.0;          // budget of a run: a busy machine is no failure [s]
constexpr double kPassageAngle = 2.5;             // of the crank at the start [rad]
constexpr double kPassageSpread = 0.1;            // over all starts [rad]
constexpr double kPassageSpeed = 4.0;             // of the crank [rad/s]
const std::string kPassage = "four_bar, folding flat";

const ExperimentInfo kInfo{
    .name = "mechanisms",
    .question =
        "What accuracy does each integrator reach on mechanisms with hard and redundant rows, at what cost, "
        "and do the joints stay closed?",
    .not_modelled = "Friction, contacts, step-size control and several threads.",
    .settings =
        {{"scenes", Kind::kTexts, "double_pendulum,n_pendulum:n=10,four_bar,slider_crank,heavy_top",
          "double_pendulum,n_pendulum:n=10,n_pendulum:n=100,four_bar,slider_crank,flexible_linkage,heavy_top",
          "models with at most one parameter each"},
         {"rates", Kind::kNumbers, "125:4000:6", "125:64000:10", "steps per second"},
         {"passage_dt", Kind::kNumbers, "5e-4:1e-2:4", "3e-5:1e-2:11", "steps through the change point, s"},
         {"passage_starts", Kind::kInteger, "10", "100", "start angles before the change point"},
         {"judge_accuracy", Kind::kNumber, "1e-7", "1e-10",
          "agreement asked of the judge, of the scene's size"},
         {"judge_seconds", Kind::kNumber, "1", "120", "budget of the judge on a scene, s"},
         {"repeats", Kind::kInteger, "1", "3", "timed runs"},
         {"max_seconds", Kind::kNumber, "0.12", "60", "budget of a run, s"}},
    .columns = {"study", "scene", "integrator", "dt", "status", "reason", "steps", "error", "reference_error",
                "energy_drift", "gap", "velocity_gap", "redundant_rows", "start_angle", "passage", "seconds",
                "scene_length"},
    .cases = {"every integrator x scenes x rates", "every integrator x passage_dt x passage_starts"}};

// ---- Scenes

struct Scene {
  std::string name;
  Model model;
  double end = 0.0;  // [s]
  Reference judge;
  double start_angle = kNone;  // of a passage [rad]
  bool passage() const { return std::isfinite(start_angle); }
};

Scene make_scene(Context& context, const std::string& spec) {
  Scene scene{spec, make_model(spec), 0.0, {}, kNone};
  scene.end = observation_time(scene.model);
  ReferenceOptions options;
  options.halving_accuracy = context.settings.number("judge_accuracy");
  options.halving_seconds = context.settings.number("judge_seconds");
  scene.judge = make_reference(scene.model.system, scene.model.state, scene.end, options);
  const Status& status = scene.judge.status;
  if (status.ok())
    context.note(
        fmt::format("Judge of {}: {}, own error {:.1e} m.", spec, scene.judge.method, scene.judge.error));
  else
    context.fail(Status::failure(status.code, "the judge on " + spec + ": " + status.reason));
  return scene;
}

// Bodies 0 and 2 are its crank and its rocker.
Scene make_passage(double angle) {
  FourBar options;
  options.ground = options.coupler = 1.0;
  options.crank = options.rocker = 0.4;
  options.angle = angle, options.speed = kPassageSpeed;
  Scene scene{kPassage, make_four_bar(options), kPassageTime, {}, angle};
  scene.judge.error = kNone;
  return scene;
}

// ---- What is seen along a run

class Watch {
 public:
  explicit Watch(const System& system) : system_(&system) {
    kkt_.prepare(system);
    kkt_.set_step(0.0, 0.0);  // only hard rows act
  }
  void look(const State& at) {
    if (!kkt_.evaluate(at.q, false).ok()) return;
    kkt_.multiply_jacobian(at.v, rate_);
    for (int k = 0; k < system_->rows; ++k) {
      if (!std::isinf(system_->stiffness[k])) continue;
      gap = std::max(gap, std::abs(kkt_.phi[k]));
      velocity_gap = std::max(velocity_gap, std::abs(rate_[k]));
    }
    turn(orientation(system_->bodies[0], at.q));
  }

  double gap = 0.0, velocity_gap = 0.0;
  double turned = 0.0;  ///< by the first body about its z axis [rad]

 private:
  void turn(const Matrix3d& axes) {
    if (seen_) turned += std::atan2(axes.col(0).dot(before_.col(1)), axes.col(0).dot(before_.col(0)));
    before_ = axes, seen_ = true;
  }

  const System* system_;
  Kkt kkt_;
  VectorXd rate_;
  Matrix3d before_;
  bool seen_ = false;
};

// How the parallelogram came out of its change point.
std::string passage_of(const Scene& scene, const Watch& watch, const State& end) {
  if (!scene.passage()) return "";
  const System& s = scene.model.system;
  if (watch.turned < std::numbers::pi - scene.start_angle) return "turned back";
  const double aligned = orientation(s.bodies[0], end.q).col(0).dot(orientation(s.bodies[2], end.q).col(0));
  return aligned > 0.99 ? "parallelogram" : "crossed";
}

// ---- One run

struct Run {
  double dt = 0.0, error = kNone, drift = kNone, gap = kNone, velocity_gap = kNone, seconds = 0.0;
  Status status;
  std::int64_t steps = 0;
  std::string passage = "";
  Cell redundant = {};
};

Run run_watched(const Scene& scene, const std::string& name, double dt, double budget) {
  const Model& model = scene.model;
  Integrator integrator = make_integrator(name, model.system);
  State state = model.state;
  History history;
  Watch watch(model.system);
  watch.look(state);
  const RunResult result = simulate(model.system, integrator, state, history,
                                    {.dt = dt,
                                     .end_time = scene.end,
                                     .max_seconds = budget,
                                     .observer = [&](const State& at, const History&) {
                                       watch.look(at);
                                       return true;
                                     }});
  Run run{.dt = dt, .seconds = result.seconds, .status = result.status, .steps = result.steps};
  if (result.steps > 0) run.gap = watch.gap, run.velocity_gap = watch.velocity_gap;
  if (const LinearSolver* solver = linear_solver(integrator); solver && result.steps > 0)
    run.redundant = static_cast<std::int64_t>(solver->rank().dependent.size());
  if (!result.status.ok()) return run;
  if (scene.judge.status.ok() && !scene.passage())
    run.error = position_error(model.system, state, scene.judge.state);
  if (!model.conserved.empty() || !model.system.driven())
    run.drift =
        (total_energy(model.system, state) - total_energy(model.system, model.state)) / energy_scale(model);
  run.passage = passage_of(scene, watch, state);
  return run;
}

double time_run(const Scene& scene, const std::string& name, double dt) {
  Integrator integrator = make_integrator(name, scene.model.system);
  State state = scene.model.state;
  History history;
  return simulate(scene.model.system, integrator, state, history, {.dt = dt, .end_time = scene.end}).seconds;
}

Cell cell(double value) {
  return std::isfinite(value) ? Cell(value) : Cell();
}

void add_row(Context& context, const Scene& scene, const IntegratorInfo& method, const Run& run) {
  context.table.add({{"study", scene.passage() ? "change point" : "accuracy"},
                     {"scene", scene.name},
                     {"integrator", method.name},
                     {"dt", run.dt},
                     {"status", to_string(run.status.code)},
                     {"reason", run.status.reason},
                     {"steps", run.steps},
                     {"error", cell(run.error)},
                     {"reference_error", cell(scene.judge.error)},
                     {"energy_drift", cell(run.drift)},
                     {"gap", cell(run.gap)},
                     {"velocity_gap", cell(run.velocity_gap)},
                     {"redundant_rows", run.redundant},
                     {"start_angle", cell(scene.start_angle)},
                     {"passage", run.passage},
                     {"seconds", run.seconds},
                     {"scene_length", scene.model.scene_length}});
}

// The nearest step that divides the run: all steps of a run are then as long as its chart says.
double whole_step(double end, double dt) {
  return end / std::max(1.0, std::round(end / dt));
}

// From long to short steps; what is refused once or takes too long is not tried finer.
void study(Context& context, const Scene& scene, const IntegratorInfo& method, std::vector<double> steps) {
  std::sort(steps.rbegin(), steps.rend());
  const auto repeats = static_cast<int>(context.settings.integer("repeats"));
  for (const double dt : steps) {
    if (context.interrupted()) return;
    Run run = run_watched(scene, method.name, dt, context.settings.number("max_seconds"));
    if (run.status.ok()) run.seconds = best_of(repeats, [&] { return time_run(scene, method.name, dt); });
    add_row(context, scene, method, run);
    if (run.status.code == StatusCode::kRefused || run.status.code == StatusCode::kLimitReached) return;
  }
}

void study_passage(Context& context, const IntegratorInfo& method) {
  const std::int64_t starts = context.settings.integer("passage_starts");
  for (const double wanted : context.settings.numbers("passage_dt")) {
    const double dt = whole_step(kPassageTime, wanted);
    for (std::int64_t i = 0; i < starts; ++i) {
      if (context.interrupted()) return;
      const double part = static_cast<double>(i) / static_cast<double>(starts);
      const Scene scene = make_passage(kPassageAngle + part * kPassageSpread);
      const Run run = run_watched(scene, method.name, dt, kPassageSeconds);
      add_row(context, scene, method, run);
      if (run.status.code == StatusCode::kRefused) return;
    }
  }
}

// ---- Charts

Chart make_chart(const Context& context, const std::vector<Scene>& scenes, const std::string& name,
                 const std::string& title, const std::string& caption, const Axis& x, const Axis& y,
                 const std::string& x_column, const std::string& y_column) {
  const Table& table = context.table;
  Chart chart{.name = name, .title = title, .caption = caption, .grid_columns = 3};
  for (const Scene& scene : scenes) {
    const bool costs = x_column == "seconds", judged = y_column == "error";
    const auto keep = [&](std::size_t row) {
      const std::string status = table.at(row, "status").text();
      return table.at(row, "scene").text() == scene.name && status != "refused" &&
             status != "limit_reached" && (!costs || status == "ok");
    };
    Panel panel{.title = scene.name,
                .x = x,
                .y = y,
                .series = with_integrator_looks(series_by(table, "integrator", x_column, y_column, keep))};
    if (judged) panel.judge_error = scene.judge.error;
    if (!costs) panel.slopes = judged ? std::vector<Slope>{{1.0}, {2.0}} : std::vector<Slope>{{2.0}};
    chart.panels.push_back(std::move(panel));
  }
  return chart;
}

void add_charts(Context& context, const std::vector<Scene>& scenes) {
  const Axis dt{.label = "time step dt [s]", .log = true}, seconds{"time of the step loop [s]", true},
      error{"position error at the end [m]", true},
      gap{.label = "largest |phi| of a hard row [m or 1]", .log = true, .min = 1e-17};
  context.add_chart(make_chart(context, scenes, "mechanisms", "Error against time step",
                               "Error at the end of a run; crosses are failed runs, hollow points lie below "
                               "the judge's own error.",
                               dt, error, "dt", "error"));
  context.add_chart(make_chart(context, scenes, "mechanisms_cost", "Error against time",
                               "The same runs over the seconds they took; lower left is better.", seconds,
                               error, "seconds", "error"));
  context.add_chart(
      make_chart(context, scenes, "mechanisms_gap", "How far joints open",
                 "Largest violation of a hard row during a run: at rounding for methods that "
                 "close positions, at the square of the step for those that only close velocities.",
                 dt, gap, "dt", "gap"));
}

// What the runs of one integrator at one step through the change point came to.
struct Passages {
  double dt = 0.0, energy = 0.0, gap = 0.0;
  int runs = 0, passed = 0, crossed = 0;
  bool refused = false;
  std::string reason = "";  // of the first failure
};

std::vector<Passages> passages_of(const Table& table, const std::string& integrator) {
  std::vector<Passages> all;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (table.at(row, "scene").text() != kPassage || table.at(row, "integrator").text() != integrator)
      continue;
    const double dt = table.at(row, "dt").number();
    const std::string status = table.at(row, "status").text(), passage = table.at(row, "passage").text();
    if (all.empty() || all.back().dt != dt) all.push_back({.dt = dt});
    Passages& p = all.back();
    ++p.runs;
    p.refused = p.refused || status == "refused";
    if (status != "ok" && p.reason.empty()) p.reason = table.at(row, "reason").text();
    if (status != "ok") continue;
    p.passed += passage != "turned back";
    p.crossed += passage == "crossed";
    p.energy = std::max(p.energy, std::abs(table.at(row, "energy_drift").number()));
    p.gap = std::max(p.gap, table.at(row, "gap").number());
  }
  return all;
}

void add_passage_chart(Context& context) {
  const Axis dt{.label = "time step dt [s]", .log = true};
  Panel share{.title = "runs that get through",
              .x = dt,
              .y = {.label = "fraction of the starts [1]", .min = -0.05, .max = 1.05}};
  Panel energy{.title = "energy error of those",
               .x = dt,
               .y = {.label = "largest |energy drift| / energy scale [1]", .log = true}};
  Panel gap{.title = "gap of those",
            .x = dt,
            .y = {.label = "largest |phi| of a hard row [m or 1]", .log = true, .min = 1e-17}};
  for (const std::string& name : context.table.distinct("integrator")) {
    Series shares{.label = name}, energies{.label = name}, gaps{.label = name};
    for (const Passages& p : passages_of(context.table, name)) {
      if (p.refused) continue;
      shares.add(p.dt, static_cast<double>(p.passed) / p.runs);
      if (p.passed > 0) energies.add(p.dt, p.energy), gaps.add(p.dt, p.gap);
    }
    if (shares.x.empty()) continue;
    share.series.push_back(shares), energy.series.push_back(energies), gap.series.push_back(gaps);
  }
  Chart chart{.name = "mechanisms_passage",
              .title = "A parallelogram through its flat pose",
              .caption =
                  "From different start angles: how many runs get through, and the largest "
                  "energy error and gap among those that do.",
              .grid_columns = 3};
  for (Panel* panel : {&share, &energy, &gap}) {
    panel->series = with_integrator_looks(std::move(panel->series));
    chart.panels.push_back(std::move(*panel));
  }
  context.add_chart(std::move(chart));
}

// ---- Conclusions, read from the rows

void note_cheapest(Context& context, const Scene& scene) {
  const Table& table = context.table;
  std::string line;
  for (const double level : kLevels) {
    std::size_t best = table.rows();
    const bool known = level * scene.model.scene_length > scene.judge.error;
    for (std::size_t row = 0; known && row < table.rows(); ++row)
      if (table.at(row, "scene").text() == scene.name && table.at(row, "status").text() == "ok" &&
          table.at(row, "error").number() <= level * scene.model.scene_length &&
          (best == table.rows() || table.at(row, "seconds").number() < table.at(best, "seconds").number()))
        best = row;
    line += fmt::format("{}{:.0e}: ", line.empty() ? "" : "; ", level);
    line += best == table.rows() ? (known ? "none" : "below the judge's own error")
                                 : fmt::format("{} dt {:.2g} s, {:.3g}", table.at(best, "integrator").text(),
                                               table.at(best, "dt").number(),
                                               1e3 * table.at(best, "seconds").number() / scene.end);
  }
  context.note(fmt::format(
      "{}, cheapest at errors up to a fraction of the scene's length (ms per simulated second): {}.",
      scene.name, line));
}

void note_gaps(Context& context) {
  const Table& table = context.table;
  std::string line;
  for (const std::string& name : table.distinct("integrator")) {
    double gap = kNone, rate = kNone;
    for (std::size_t row = 0; row < table.rows(); ++row)
      if (table.at(row, "integrator").text() == name && table.at(row, "study").text() == "accuracy" &&
          table.at(row, "status").text() == "ok") {
        gap = std::fmax(gap, table.at(row, "gap").number());
        rate = std::fmax(rate, table.at(row, "velocity_gap").number());
      }
    if (std::isfinite(gap))
      line += fmt::format("{}{} {:.1e} and {:.1e}", line.empty() ? "" : ", ", name, gap, rate);
  }
  context.note("Largest gap and velocity gap over all scenes: " + line + ".");
}

void note_passage(Context& context) {
  for (const std::string& name : context.table.distinct("integrator")) {
    std::string line, reason;
    for (const Passages& p : passages_of(context.table, name)) {
      line += fmt::format("{}{:.1e} s: {} of {}", line.empty() ? "" : "; ", p.dt, p.passed, p.runs);
      if (p.passed > 0) line += fmt::format(", energy {:.1e}, gap {:.1e}", p.energy, p.gap);
      if (p.crossed > 0) line += fmt::format(", {} crossed", p.crossed);
      if (reason.empty()) reason = p.reason;
    }
    if (!reason.empty()) line += "; first failure: " + reason;
    if (!line.empty()) context.note(fmt::format("Through the flat pose, {}: {}.", name, line));
  }
}

// Everything is checked before the first step.
void check(const Settings& settings) {
  for (const std::string& spec : settings.texts("scenes"))
    if (make_model(spec).system.bodies.empty())
      throw InputError("setting 'scenes': model '" + spec + "' has no bodies, expected a mechanism");
  for (const char* key : {"rates", "passage_dt"})
    for (const double value : settings.numbers(key))
      require_positive(fmt::format("setting '{}'", key), "value", value, "");
  for (const char* key : {"judge_accuracy", "judge_seconds", "max_seconds"})
    require_positive(fmt::format("setting '{}'", key), "value", settings.number(key), "");
  for (const char* key : {"repeats", "passage_starts"})
    if (settings.integer(key) < 1)
      fail_input(fmt::format("setting '{}'", key), "value", static_cast<double>(settings.integer(key)), "",
                 "at least 1");
}

std::vector<double> steps_of(const Context& context, const Scene& scene) {
  std::vector<double> steps;
  for (const double rate : context.settings.numbers("rates"))
    steps.push_back(whole_step(scene.end, 1.0 / rate));
  return steps;
}

void body(Context& context) {
  check(context.settings);
  const std::vector<std::string> specs = context.settings.texts("scenes");
  const std::vector<IntegratorInfo> methods = integrator_list();
  context.progress.start(static_cast<long>(methods.size() * (specs.size() + 1)));
  std::vector<Scene> scenes;
  for (const std::string& spec : specs) {
    if (context.interrupted()) break;
    Scene scene = make_scene(context, spec);
    if (!scene.judge.status.ok()) continue;
    scenes.push_back(std::move(scene));
    for (const IntegratorInfo& method : methods) {
      if (context.interrupted()) break;
      study(context, scenes.back(), method, steps_of(context, scenes.back()));
      context.progress.advance(spec + " " + method.name);
    }
    note_cheapest(context, scenes.back());
  }
  for (const IntegratorInfo& method : methods) {
    study_passage(context, method);
    context.progress.advance(kPassage + " " + method.name);
  }
  add_charts(context, scenes);
  add_passage_chart(context);
  note_gaps(context);
  note_passage(context);
}

}  // namespace
}  // namespace feder::experiments

int main(int argc, char** argv) {
  return feder::experiments::run_experiment(feder::experiments::kInfo, argc, argv, feder::experiments::body);
}
