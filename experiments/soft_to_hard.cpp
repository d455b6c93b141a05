// One code path from springs to joints: the stiffness d of every row runs from soft to infinite, the
// compliance c = 1/d to exactly 0. For fixed integrator, step and end time the state is smooth in c,
//   q(c) = q(0) + a c + O(c^2):   the mass-weighted distance to the rigid run falls like 1/d, slope -1
//   limit (Richardson in c):      (d2 q(1/d2) - d1 q(1/d1)) / (d2 - d1), to be met by the run with c = 0
// Linear range: the four decades of d that lie straightest on log-log axes, and the stiffer points on that
// line.
#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "engine/check.h"
#include "experiments/support/experiment.h"
#include "experiments/support/measure.h"
#include "experiments/support/timing.h"
#include "models/catalog.h"
#include "solvers/reference.h"
#include "solvers/simulate.h"

namespace feder::experiments {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kDecades = 1e4;      // length of the fit
constexpr double kLinear = 0.01;      // distance from the line that still counts as on it
constexpr double kRounding = 1e-13;   // of the scene's length: below, distances to rigid are rounding
constexpr double kLimitBound = 1e-8;  // of the scene's length: c = 0 against the extrapolated limit
constexpr double kSlopeBound = 0.05;  // distance from -1 that is called agreement
constexpr double kLeastDrawn = 1e-14, kMostDrawn = 10.0;  // distances in the charts [m]
constexpr double kRigidShift = 100.0;  // where the charts draw c = 0, right of the stiffest spring

const std::vector<std::string> kIntegrators = {"implicit_euler_notes", "implicit_euler_geometric",
                                               "implicit_euler_newton"};
const std::vector<std::string> kRoutes = {"kkt", "dual", "auto"};

// ---- One run

struct Point {
  double stiffness = 0.0;
  Status status;
  State end;
  std::int64_t steps = 0;
  std::string route;                       // the one that ran
  double distance = kNaN, on_line = kNaN;  // to the rigid run [m]; against the fitted line
  double backward_error = 0.0, refinements = 0.0, iterations = 0.0;
  std::vector<double> seconds;  // per step and repeat
  double cost() const { return median(seconds); }
};

struct Scene {
  std::string spec;
  double dt = 0.0, end = 0.0;
  std::vector<double> stiffness;  // the last one is infinite
  std::vector<Model> models;      // one per stiffness
};

// The first step is left out of the cost: it alone allocates and looks at the rank of the hard rows.
void run_point(const Scene& scene, const Model& model, const std::string& integrator_name,
               const std::string& route, Point& point) {
  IntegratorOptions choice;
  choice.route = route;
  Integrator integrator = make_integrator(integrator_name, model.system, choice);
  State state = model.state;
  History history;
  Stopwatch watch;
  bool first = true;
  RunOptions options{.dt = scene.dt, .end_time = scene.end};
  options.observer = [&](const State&, const History&) {
    if (std::exchange(first, false)) watch.restart();
    return true;
  };
  RunResult run = simulate(model.system, integrator, state, history, options);
  const double seconds = watch.seconds();
  point.status = std::move(run.status);
  point.steps = run.steps;
  if (point.steps > 1 && point.status.ok())
    point.seconds.push_back(seconds / static_cast<double>(point.steps - 1));
  const LinearSolver& solver = *linear_solver(integrator);
  const double steps = std::max(1.0, static_cast<double>(point.steps));
  if (point.steps > 0) point.route = solver.route_name();
  point.backward_error = solver.times().worst_backward_error;
  point.refinements = static_cast<double>(solver.times().refinements) / steps;
  point.iterations = static_cast<double>(solver.times().solves) / steps;
  point.end = std::move(state);
}

// ---- One sweep: all stiffnesses of a scene, by one integrator and route

struct Sweep {
  std::string integrator, route;
  std::vector<Point> points;  // the last one is rigid
  Line fit;                   // of log distance over log d
  double fit_from = kNaN, fit_to = kNaN;
  double limit_from = kNaN, limit_to = kNaN, limit_difference = kNaN;  // relative to the scene's length
  double cost_jump = kNaN, distance_jump = kNaN;
  bool refused() const { return points.back().status.code == StatusCode::kRefused; }
  double line(double d) const { return std::exp(fit.offset + fit.slope * std::log(d)); }
};

// The repeats go through the whole sweep, so that a disturbance of the machine does not fall on one
// stiffness.
void run_points(Context& context, const Scene& scene, Sweep& sweep) {
  sweep.points.resize(scene.stiffness.size());
  for (std::int64_t repeat = 0; repeat < context.settings.integer("repeats"); ++repeat)
    for (std::size_t i = 0; i < sweep.points.size() && !context.interrupted(); ++i) {
      sweep.points[i].stiffness = scene.stiffness[i];
      if (!sweep.points[i].status.ok()) continue;
      run_point(scene, scene.models[i], sweep.integrator, sweep.route, sweep.points[i]);
    }
}

void measure_distances(const Scene& scene, Sweep& sweep) {
  const Point& rigid = sweep.points.back();
  for (std::size_t i = 0; i < sweep.points.size(); ++i)
    if (rigid.status.ok() && sweep.points[i].status.ok())
      sweep.points[i].distance = position_error(scene.models[i].system, sweep.points[i].end, rigid.end);
}

bool measured(const Scene& scene, const Point& p) {
  return std::isfinite(p.stiffness) && p.distance > kRounding * scene.models.back().scene_length;
}

// The straightest four decades.
void fit_line_to(const Scene& scene, Sweep& sweep) {
  for (const Point& first : sweep.points) {
    std::vector<double> d, distance;
    for (const Point& p : sweep.points)
      if (p.stiffness >= first.stiffness && p.stiffness <= first.stiffness * kDecades * (1.0 + 1e-9) &&
          measured(scene, p))
        d.push_back(p.stiffness), distance.push_back(p.distance);
    if (d.size() < 3 || d.back() < d.front() * kDecades * (1.0 - 1e-9)) continue;
    const Line line = fit_power(d, distance);
    if (sweep.fit.slope_error <= line.slope_error) continue;
    sweep.fit = line;
    sweep.fit_from = d.front(), sweep.fit_to = d.back();
  }
  for (Point& p : sweep.points)
    if (std::isfinite(p.stiffness)) p.on_line = p.distance / sweep.line(p.stiffness);
}

// From the two largest stiffnesses on the line; orientations are extrapolated and normalised.
void compare_limit(const Scene& scene, Sweep& sweep) {
  const Point *soft = nullptr, *stiff = nullptr;
  for (const Point& p : sweep.points)
    if (measured(scene, p) && std::abs(p.on_line - 1.0) < kLinear) soft = std::exchange(stiff, &p);
  if (!soft) return;
  const Model& model = scene.models.back();
  const double weight = stiff->stiffness / (stiff->stiffness - soft->stiffness);
  State limit = stiff->end;
  limit.q += (weight - 1.0) * (stiff->end.q - soft->end.q);
  for (const Body& b : model.system.bodies) limit.q.segment<4>(b.quaternion).normalize();
  sweep.limit_from = soft->stiffness, sweep.limit_to = stiff->stiffness;
  sweep.limit_difference = position_error(model.system, limit, sweep.points.back().end) / model.scene_length;
}

// Largest ratio of neighbours, whichever is larger.
void look_for_jumps(const Scene& scene, Sweep& sweep) {
  const auto grow = [](double& largest, double a, double b) {
    if (std::isfinite(a / b)) largest = std::fmax(largest, std::max(a / b, b / a));
  };
  for (std::size_t i = 1; i < sweep.points.size(); ++i) {
    const Point &a = sweep.points[i - 1], &b = sweep.points[i];
    grow(sweep.cost_jump, a.cost(), b.cost());
    const double end = std::max(sweep.fit_to, sweep.limit_to);  // beyond, rounding decides
    if (measured(scene, a) && measured(scene, b) && !(b.stiffness > end))
      grow(sweep.distance_jump, a.on_line, b.on_line);
  }
}

// ---- The table

Cell if_finite(double x) {
  return std::isfinite(x) ? Cell(x) : Cell();
}

void add_rows(Context& context, const Scene& scene, const Sweep& sweep) {
  for (const Point& p : sweep.points)
    context.table.add({{"scene", scene.spec},
                       {"integrator", sweep.integrator},
                       {"route", sweep.route},
                       {"route_taken", p.route},
                       {"stiffness", p.stiffness},
                       {"dt", scene.dt},
                       {"end_time", scene.end},
                       {"status", to_string(p.status.code)},
                       {"reason", p.status.reason},
                       {"steps", p.steps},
                       {"distance", if_finite(p.distance)},
                       {"distance_on_line", if_finite(p.on_line)},
                       {"slope", if_finite(sweep.fit.slope)},
                       {"slope_error", if_finite(sweep.fit.slope_error)},
                       {"slope_from", if_finite(sweep.fit_from)},
                       {"slope_to", if_finite(sweep.fit_to)},
                       {"limit_difference", if_finite(sweep.limit_difference)},
                       {"limit_from", if_finite(sweep.limit_from)},
                       {"limit_to", if_finite(sweep.limit_to)},
                       {"backward_error", p.steps > 0 ? Cell(p.backward_error) : Cell()},
                       {"refinements_per_step", p.steps > 0 ? Cell(p.refinements) : Cell()},
                       {"solves_per_step", p.steps > 0 ? Cell(p.iterations) : Cell()},
                       {"seconds_per_step", if_finite(p.cost())},
                       {"seconds_jump", if_finite(sweep.cost_jump)},
                       {"distance_jump", if_finite(sweep.distance_jump)}});
}

// ---- Charts

// Places right of the stiffest spring stand for c = 0.
double rigid_place(const Scene& scene) {
  return kRigidShift * scene.stiffness[scene.stiffness.size() - 2];
}

Series curve(const Scene& scene, const Sweep& sweep, std::size_t look, double (*value)(const Point&)) {
  Series series{.label = sweep.route, .look = look};
  for (const Point& p : sweep.points) {
    const double x = std::min(p.stiffness, rigid_place(scene));
    if (!p.status.ok())
      series.failed_x.push_back(x);
    else if (value(p) > 0.0)
      series.add(x, value(p));
  }
  return series;
}

Panel make_panel(const Scene& scene, const std::vector<Sweep>& sweeps, const std::string& integrator,
                 const std::string& y_label, double (*value)(const Point&)) {
  Panel panel{.title = fmt::format("{}, {}", scene.spec, integrator),
              .x = {.label = "stiffness d [N/m]", .log = true},
              .y = {.label = y_label, .log = true}};
  for (std::size_t look = 0; look < kRoutes.size(); ++look)
    for (const Sweep& sweep : sweeps)
      if (sweep.integrator == integrator && sweep.route == kRoutes[look] && !sweep.refused())
        panel.series.push_back(curve(scene, sweep, look, value));
  return panel;
}

// The fitted slope, drawn a little under the end of the fit.
void add_slope(Panel& panel, const std::vector<Sweep>& sweeps, const std::string& integrator) {
  for (const Sweep& sweep : sweeps)
    if (sweep.integrator == integrator && std::isfinite(sweep.fit.slope)) {
      panel.slopes.push_back({.order = sweep.fit.slope,
                              .label = fmt::format("slope {:.4f}", sweep.fit.slope),
                              .x = sweep.fit_to,
                              .y = 0.1 * sweep.line(sweep.fit_to)});
      return;
    }
}

struct Charts {
  Chart distance{
      .name = "soft_to_hard_distance",
      .title = "From springs to joints: distance to the rigid run",
      .caption =
          "A spring that becomes a joint falls along slope -1 until rounding; on a flat curve it does not; "
          "crosses are failed runs.",
      .grid_columns = 3};
  Chart seconds{.name = "soft_to_hard_seconds",
                .title = "From springs to joints: cost of a step",
                .caption = "Seconds per step; the mark on the right stands for rigid rows, c = 0.",
                .grid_columns = 3};
};

// Whole decades around all costs of the scene: the same axis for its integrators.
std::pair<double, double> cost_range(const std::vector<Sweep>& sweeps) {
  double least = kInfinity, largest = 0.0;
  for (const Sweep& sweep : sweeps)
    for (const Point& p : sweep.points)
      if (p.status.ok()) least = std::min(least, p.cost()), largest = std::max(largest, p.cost());
  return {std::pow(10.0, std::floor(std::log10(least))), std::pow(10.0, std::ceil(std::log10(largest)))};
}

void add_panels(const Scene& scene, const std::vector<Sweep>& sweeps, Charts& charts) {
  const auto [least_cost, largest_cost] = cost_range(sweeps);
  for (const std::string& integrator : kIntegrators) {
    Panel distance = make_panel(scene, sweeps, integrator, "distance to rigid [m]",
                                [](const Point& p) { return p.distance; });
    distance.y.min = kLeastDrawn, distance.y.max = kMostDrawn;
    add_slope(distance, sweeps, integrator);
    charts.distance.panels.push_back(std::move(distance));
    Panel seconds =
        make_panel(scene, sweeps, integrator, "time per step [s]", [](const Point& p) { return p.cost(); });
    if (largest_cost > 0.0) seconds.y.min = least_cost, seconds.y.max = largest_cost;
    seconds.marks = {{rigid_place(scene), "rigid", true}};
    charts.seconds.panels.push_back(std::move(seconds));
  }
}

// ---- Conclusions

void note_sweep(Context& context, const Scene& scene, const Sweep& sweep) {
  if (sweep.refused()) return;
  int failed = 0;
  std::string reason;
  double worst = 0.0;
  for (const Point& p : sweep.points) {
    worst = std::max(worst, p.backward_error);
    if (!p.status.ok() && failed++ == 0)
      reason = fmt::format(", first at d = {:.1e} ({})", p.stiffness, p.status.reason);
  }
  const bool holds = std::abs(sweep.fit.slope + 1.0) <= kSlopeBound && sweep.limit_difference <= kLimitBound;
  context.note(fmt::format(
      "{}, {}, {}: slope {:.4f} over d = {:.0e}..{:.0e}, c = 0 misses the limit extrapolated from {:.0e} and "
      "{:.0e} by {:.1e} of the scene{}; worst backward error {:.1e}; neighbours differ at most {:.2f} times "
      "in "
      "cost, {:.3f} times in distance against the line; {} failed{}.",
      scene.spec, sweep.integrator, sweep.route, sweep.fit.slope, sweep.fit_from, sweep.fit_to,
      sweep.limit_from, sweep.limit_to, sweep.limit_difference, holds ? "" : " (NOT a smooth limit)", worst,
      sweep.cost_jump, sweep.distance_jump, failed, reason));
}

// ---- The experiment

Scene make_scene(const Settings& settings, const std::string& spec) {
  Scene scene{spec, settings.number("dt"), 0.0, settings.numbers("stiffness"), {}};
  scene.stiffness.push_back(kInfinity);
  const char* join = spec.find(':') == std::string::npos ? ":" : ",";
  for (const double d : scene.stiffness)
    scene.models.push_back(make_model(
        spec + join + (std::isinf(d) ? std::string("stiffness=inf") : fmt::format("stiffness={:.17g}", d))));
  scene.end = std::min(settings.number("end_time"), scene.models.back().end_time);
  return scene;
}

void body(Context& context) {
  const Settings& settings = context.settings;
  require_positive("setting 'dt'", "dt", settings.number("dt"), "s");
  require_positive("setting 'end_time'", "end time", settings.number("end_time"), "s");
  if (settings.numbers("stiffness").size() < 2)
    fail_input("setting 'stiffness'", "stiffnesses", 1.0, "", "at least two");
  std::vector<Scene> scenes;
  for (const std::string& spec : settings.texts("scenes")) scenes.push_back(make_scene(settings, spec));
  context.progress.start(static_cast<long>(scenes.size() * kIntegrators.size() * kRoutes.size()));
  Charts charts;
  for (const Scene& scene : scenes) {
    std::vector<Sweep> sweeps;
    for (const std::string& integrator : kIntegrators)
      for (const std::string& route : kRoutes) {
        Sweep& sweep = sweeps.emplace_back();
        sweep.integrator = integrator, sweep.route = route;
        run_points(context, scene, sweep);
        if (context.interrupted()) return;
        measure_distances(scene, sweep);
        fit_line_to(scene, sweep);
        compare_limit(scene, sweep);
        look_for_jumps(scene, sweep);
        add_rows(context, scene, sweep);
        note_sweep(context, scene, sweep);
        context.progress.advance(fmt::format("{} {} {}", scene.spec, integrator, route));
      }
    add_panels(scene, sweeps, charts);
  }
  context.add_chart(std::move(charts.distance));
  context.add_chart(std::move(charts.seconds));
}

ExperimentInfo about() {
  return {
      .name = "soft_to_hard",
      .question = "Does a spring become a joint as its stiffness grows, at the same cost and without a jump?",
      .not_modelled = "Damping, steps that resolve the springs, and rows that depend on each other.",
      .settings = {{"scenes", Kind::kTexts, "rigid_chain:n=10,hanging_chain:n=10,pendulum:angle=1.5",
                    "rigid_chain:n=10,rigid_chain:n=100,hanging_chain:n=10,hanging_chain:n=100,pendulum:"
                    "angle=1.5",
                    "models with a stiffness that may be infinite, at most one parameter each"},
                   {"stiffness", Kind::kNumbers, "1e2:1e14:13", "1e2:1e14:49",
                    "of every row, N/m; infinity is added"},
                   {"dt", Kind::kNumber, "1e-2", "1e-2", "time step, s"},
                   {"end_time", Kind::kNumber, "0.25", "0.25", "length of a run, s"},
                   {"repeats", Kind::kInteger, "15", "25", "runs timed; failed ones are not repeated"}},
      .columns = {"scene",           "integrator",       "route",
                  "route_taken",     "stiffness",        "dt",
                  "end_time",        "status",           "reason",
                  "steps",           "distance",         "distance_on_line",
                  "slope",           "slope_error",      "slope_from",
                  "slope_to",        "limit_difference", "limit_from",
                  "limit_to",        "backward_error",   "refinements_per_step",
                  "solves_per_step", "seconds_per_step", "seconds_jump",
                  "distance_jump"},
      .cases = {"scenes x implicit integrators x routes kkt, dual, auto x stiffness, and infinity"}};
}

}  // namespace
}  // namespace feder::experiments

int main(int argc, char** argv) {
  return feder::experiments::run_experiment(feder::experiments::about(), argc, argv,
                                            feder::experiments::body);
}
