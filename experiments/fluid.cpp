// How far can the step of a fluid go, what does a particle cost, and how right are pressure, float and front?
//   limit:      bisection on dt; too long is where the kinetic energy of a column passes kBlownUp times that
//               at half the predicted limit (solvers/fluid_stability.h), against 0.4 h/c and h^2/(8 nu)
//   cost:       one evaluation of all forces of a shaken lattice in space
//   pressure:   mean of each layer of a settled column against rho g depth
//   float:      draft of a box at rest against Archimedes'
//   front:      of a dam break against Ritter's 2 sqrt(g height)
//   projection: of one step of an incompressible column, by sweeps and directly
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>

#include "engine/energy.h"
#include "engine/fluid/density_rows.h"
#include "experiments/support/experiment.h"
#include "experiments/support/measure.h"
#include "experiments/support/timing.h"
#include "models/catalog.h"
#include "models/dam_break.h"
#include "models/floating_body.h"
#include "models/hydrostatic_column.h"
#include "solvers/fluid_stability.h"
#include "solvers/simulate.h"

namespace feder::experiments {
namespace {

constexpr double kBlownUp = 10.0;  // times the kinetic energy of a stable run
constexpr double kPart = 0.2;      // of h/c: the step of the runs
constexpr int kTrialSteps = 600;

const ExperimentInfo kInfo{
    .name = "fluid",
    .question =
        "How far can the step of a smoothed fluid go, what does a particle cost, and how right are the "
        "pressure at depth, the draft of a floating box and the front of a dam break?",
    .not_modelled = "Surface tension, turbulence, gas above the surface, more than one thread.",
    .settings = {{"viscosities", Kind::kNumbers, "1,10,100,300,1000,3000,1e4", "1,10,30,100,300,1e3,3e3,1e4",
                  "Pa s"},
                 {"supports", Kind::kNumbers, "2,3,4", "2,2.5,3,3.5,4,5", "of the kernel, in spacings"},
                 {"particles", Kind::kNumbers, "1e3,1e4,1e5", "1e3,1e4,1e5,3e5,1e6", "in space, timed"},
                 {"column_layers", Kind::kNumbers, "12,24", "12,24,48", "of the settled column"},
                 {"box_sides", Kind::kNumbers, "6,12", "6,12,24,48", "spacings along the floating box"},
                 {"dam_layers", Kind::kNumbers, "8,16,32", "8,16,32,64", "of the dam"},
                 {"projection_layers", Kind::kNumbers, "24,71", "24,45,71", "of a square column"},
                 {"sweeps", Kind::kNumbers, "0,1,3,10,30,100,300",
                  "0,1,2,5,10,20,50,100,200,500,1000,2000,5000", "over the density rows; 0: direct"},
                 {"repeats", Kind::kInteger, "3", "7", "timings, of which the best counts"}},
    .columns = {"study",       "scene",      "integrator", "dt",      "status",     "reason",
                "steps",       "seconds",    "particles",  "support", "viscosity",  "dt_predicted",
                "dt_measured", "dt_courant", "dt_viscous", "depth",   "side",       "time",
                "measured",    "ideal",      "solver",     "sweeps",  "compression"},
    .cases = {"limit over viscosity and support", "cost over particles",
              "pressure, float, front over spacing", "projection by sweeps and directly"}};

double sound_step(const System& s) {
  return kPart * s.fluid->material().support / s.fluid->material().sound_speed;
}

struct Run {
  State state;
  RunResult result = {};
};
Run run_to(const Model& model, Run run, double end_time) {
  Integrator integrator = make_integrator("leapfrog", model.system);
  History history;
  run.result = simulate(model.system, integrator, run.state, history,
                        {.dt = sound_step(model.system), .end_time = end_time});
  return run;
}

// A figure of a textbook: where (`at`), what came out and what should.
void add_figure(Context& context, const std::string& study, const std::string& scene, const Model& model,
                const Run& run, const std::string& at, double where, double measured, double ideal) {
  context.table.add({{"study", study},
                     {"scene", scene},
                     {"integrator", "leapfrog"},
                     {"dt", sound_step(model.system)},
                     {"status", to_string(run.result.status.code)},
                     {"reason", run.result.status.reason},
                     {"steps", run.result.steps},
                     {"seconds", run.result.seconds},
                     {"particles", model.system.fluid->particles().size()},
                     {at, where},
                     {"measured", measured},
                     {"ideal", ideal}});
}

// ---- The limit

// Largest kinetic energy within kTrialSteps of leapfrog; infinite where a step fails.
double most_energy(const Model& model, double dt) {
  Leapfrog leapfrog(model.system, {});
  State state = model.state;
  History history;
  double most = 0.0;
  Status status = leapfrog.prepare();
  for (int i = 0; i < kTrialSteps; ++i) {
    if (status.ok()) status = leapfrog.step(dt, state, history, nullptr);
    most = std::max(most, kinetic_energy(model.system, state));
    if (!status.ok() || !std::isfinite(state.v.sum())) return std::numeric_limits<double>::infinity();
  }
  return most;
}

void study_limit(Context& context, const std::string& study, double viscosity, double support) {
  HydrostaticColumn options;
  options.layers = 10, options.columns = 5, options.push = 0.0;
  options.sound_speed = 100.0, options.viscosity = viscosity, options.support = support;
  const Model model = make_hydrostatic_column(options);
  const double h = model.system.fluid->material().support;
  const FluidRates rates = largest_fluid_rates(model.system, model.state);
  const double predicted = fluid_step_limit(rates), calm = most_energy(model, 0.5 * predicted);
  double stable = 0.5 * predicted, too_long = 4.0 * predicted;
  while (too_long > 1.01 * stable) {
    const double dt = std::sqrt(stable * too_long);
    (most_energy(model, dt) > kBlownUp * calm ? too_long : stable) = dt;
  }
  context.table.add({{"study", study},
                     {"scene", "hydrostatic_column"},
                     {"integrator", "leapfrog"},
                     {"status", "ok"},
                     {"support", support},
                     {"viscosity", viscosity},
                     {"dt_predicted", predicted},
                     {"dt_measured", std::sqrt(stable * too_long)},
                     {"dt_courant", rates.courant},
                     {"dt_viscous", 0.125 * h * h * options.rest_density / viscosity}});
}

// ---- The cost

void study_cost(Context& context, double particles) {
  const int edge = static_cast<int>(std::lround(std::cbrt(particles)));
  SystemBuilder builder;
  std::mt19937_64 random(context.seed);
  auto shake = [&] { return 0.2 * (2.0 * static_cast<double>(random() >> 11) * 0x1p-53 - 1.0); };
  std::vector<int> nodes;
  for (int i = 0; i < edge; ++i)
    for (int j = 0; j < edge; ++j)
      for (int k = 0; k < edge; ++k)
        nodes.push_back(builder.add_particle(1000.0, {i + shake(), j + shake(), k + shake()}).node);
  builder.set_fluid(std::make_shared<Fluid>(FluidMaterial{.support = 2.5}, nodes));
  const auto [system, state] = builder.build();
  VectorXd f = VectorXd::Zero(state.v.size());
  const double seconds = best_of(static_cast<int>(context.settings.integer("repeats")), [&] {
    const Stopwatch watch;
    system.fluid->add_forces(state.q, state.v, f);
    return watch.seconds();
  });
  context.table.add({{"study", "cost"},
                     {"status", "ok"},
                     {"seconds", seconds},
                     {"particles", nodes.size()},
                     {"support", 2.5}});
}

// ---- Pressure, float, front

void study_pressure(Context& context, int layers) {
  HydrostaticColumn options;
  options.layers = options.columns = layers;
  options.push = 0.0, options.viscosity = 3.0;
  options.drag = 2e4 / (layers * layers);  // the same rate for all
  const Model model = make_hydrostatic_column(options);
  const Run run = run_to(model, {model.state}, 2.5);
  const Fluid& fluid = *model.system.fluid;
  VectorXd rho;
  fluid.densities(run.state.q, rho);
  for (int j = 0; j < layers; ++j) {  // particles keep their layer
    double height = 0.0, pressure = 0.0;
    for (int i = 0; i < layers; ++i) {
      height += run.state.q[3 * fluid.particles()[j * layers + i] + 1] / layers;
      pressure += fluid.pressure(rho[j * layers + i]) / layers;
    }
    const double depth = options.depth - height;
    add_figure(context, "pressure", fmt::format("{} layers", layers), model, run, "depth", depth, pressure,
               options.rest_density * options.gravity * depth);
  }
}

void study_float(Context& context, int side) {
  FloatingBody options;
  options.spacing = 0.6 / side, options.wide = options.high = side;
  options.columns = 2 * side, options.layers = side;
  options.viscosity = 3.0;
  options.drag = 720.0 / (side * side);
  const Model model = make_floating_body(options);
  const Run run = run_to(model, {model.state}, 2.5);
  add_figure(context, "float", fmt::format("box of {} spacings", side), model, run, "side", side,
             draft(options, model.system, run.state) / 0.3, 1.0);
}

void study_front(Context& context, int layers) {
  constexpr double kEnd = 0.4, kEvery = 0.04;
  DamBreak options;
  options.layers = layers;
  const Model model = make_dam_break(options);
  Run run{model.state};
  for (double time = kEvery; time < kEnd + 0.5 * kEvery && run.result.status.ok(); time += kEvery) {
    run = run_to(model, run, time);
    const double reach = front(model.system, run.state, 1.5 * options.height / layers) - options.width;
    add_figure(context, "front", fmt::format("{} layers", layers), model, run, "time", time, reach,
               2.0 * std::sqrt(options.gravity * options.height) * time);
  }
}

// ---- Projection

// What one step leaves of its rows, largest phi + dt phidot(v'), and the time it takes.
void add_projection(Context& context, const Model& model, int sweeps) {
  constexpr double kStep = 2e-3;
  const IntegratorOptions options{.route = sweeps ? "sweeps" : "auto", .sweeps = std::max(1, sweeps)};
  State state;
  Status status;
  const double seconds = best_of(static_cast<int>(context.settings.integer("repeats")), [&] {
    SymplecticEuler method(model.system, options);
    History history;
    state = model.state;
    const Stopwatch watch;
    status = method.prepare();
    if (status.ok()) status = method.step(kStep, state, history, nullptr);
    return watch.seconds();
  });
  DensityRows density;
  (void)density.evaluate(*model.system.fluid, model.state.q, kStep);
  double left = 0.0;
  for (int k = 0; k < density.rows.count(); ++k)
    left = std::max(left, density.phi[k] - kStep * density.rows.multiply_row(k, state.v.data()));
  const std::size_t particles = model.system.fluid->particles().size();
  context.table.add({{"study", "projection"},
                     {"scene", "hydrostatic_column"},
                     {"integrator", "symplectic_euler"},
                     {"dt", kStep},
                     {"status", to_string(status.code)},
                     {"reason", status.reason},
                     {"seconds", seconds},
                     {"particles", particles},
                     {"solver", fmt::format("{}, {} particles", sweeps ? "sweeps" : "direct", particles)},
                     {"sweeps", sweeps},
                     {"compression", left}});
}

void study_projection(Context& context, int layers) {
  const Model model = make_model(
      fmt::format("hydrostatic_column:sound_speed=inf,push=0,layers={},columns={}", layers, layers));
  for (double sweeps : context.settings.numbers("sweeps"))
    if (!context.interrupted()) add_projection(context, model, static_cast<int>(sweeps));
}

// ---- Charts

std::function<bool(std::size_t)> of_study(const Table& table, const std::string& study) {
  return [&table, study](std::size_t row) { return table.at(row, "study").text() == study; };
}

// Columns x and y of a study.
Series curve(const Table& table, const std::string& study, const std::string& label, const std::string& x,
             const std::string& y, bool theory = false) {
  Series series{.label = label, .theory = theory};
  for (std::size_t row = 0; row < table.rows(); ++row)
    if (of_study(table, study)(row)) series.add(table.at(row, x).number(), table.at(row, y).number());
  return series;
}

std::vector<Series> by_scene(const Table& table, const std::string& study, const std::string& x,
                             const std::string& theory) {
  std::vector<Series> all = series_by(table, "scene", x, "measured", of_study(table, study));
  all.push_back(curve(table, study, theory, x, "ideal", true));
  return all;
}

Panel limit_panel(const Table& table, const std::string& study, const std::string& title,
                  const std::string& x, const std::string& label) {
  Panel panel{.title = title, .x = {.label = label, .log = x == "viscosity"}};
  panel.y = {.label = "time step dt [s]", .log = true, .min = 1e-4, .max = 1e-1};
  panel.series = {curve(table, study, "predicted", x, "dt_predicted", true),
                  curve(table, study, "measured", x, "dt_measured"),
                  curve(table, study, "0.4 h / c", x, "dt_courant"),
                  curve(table, study, "h² / (8 ν)", x, "dt_viscous")};
  panel.series[1].line = false;
  return panel;
}

void add_charts(Context& context) {
  const Table& table = context.table;
  context.add_chart(
      {.name = "fluid",
       .title = "The longest stable step of a fluid",
       .caption = "Where leapfrog blows up on a column, what the fastest rates predict, two rules.",
       .panels = {
           limit_panel(table, "limit", "support of 3 spacings", "viscosity", "viscosity [Pa s]"),
           limit_panel(table, "limit_support", "viscosity 10 Pa s", "support", "support / spacing [1]")}});
  Panel pressure{.title = "a column at rest", .x = {.label = "depth [m]"}, .y = {.label = "pressure [Pa]"}};
  pressure.series = by_scene(table, "pressure", "depth", "ρ g depth");
  for (Series& series : pressure.series) series.line = series.theory;
  Panel floating{.title = "a floating box", .x = {.label = "side / spacing [1]", .log = true}};
  floating.y = {.label = "draft / Archimedes [1]", .min = 0.95, .max = 1.05};
  floating.series = {curve(table, "float", "box", "side", "measured"),
                     curve(table, "float", "Archimedes", "side", "ideal", true)};
  Panel fronts{.title = "a dam break", .x = {.label = "time [s]"}, .y = {.label = "way of the front [m]"}};
  fronts.series = by_scene(table, "front", "time", "Ritter");
  context.add_chart({.name = "fluid_figures",
                     .title = "Figures of textbooks",
                     .caption = "Pressure of each layer, draft, front; what statics and shallow water say.",
                     .panels = {std::move(pressure), std::move(floating), std::move(fronts)},
                     .grid_columns = 3});
  context.add_chart({.name = "fluid_cost",
                     .title = "What fluids cost",
                     .caption = "Forces by one thread; what a step leaves of its density rows over its time.",
                     .panels = {{.title = "evaluation of all forces",
                                 .x = {.label = "particles [1]", .log = true},
                                 .y = {.label = "time [s]", .log = true},
                                 .series = {curve(table, "cost", "forces", "particles", "seconds")},
                                 .slopes = {{1.0}}},
                                {.title = "density rows of one step",
                                 .x = {.label = "time of a step [s]", .log = true},
                                 .y = {.label = "largest compression left [1]", .log = true},
                                 .series = series_by(table, "solver", "seconds", "compression",
                                                     of_study(table, "projection"))}}});
}

// ---- Conclusions

void note_all(Context& context) {
  const Table& table = context.table;
  std::vector<double> limit, rule, count, seconds;           // measured over predicted, over 0.4 h/c
  std::map<std::string, std::pair<double, double>> columns;  // pressure and weight
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string study = table.at(row, "study").text(), scene = table.at(row, "scene").text();
    auto number = [&](const char* column) { return table.at(row, column).number(); };
    if (study.starts_with("limit")) {
      limit.push_back(number("dt_measured") / number("dt_predicted"));
      rule.push_back(number("dt_measured") / number("dt_courant"));
    }
    if (study == "cost") count.push_back(number("particles")), seconds.push_back(number("seconds"));
    if (study == "float")
      context.note(fmt::format("{}: draft {:.3f} of Archimedes'.", scene, number("measured")));
    if (study == "projection" && number("sweeps") == 0.0)
      context.note(
          fmt::format("Direct projection of {:.0f} particles: {:.1e} of compression left after {:.2g} s.",
                      number("particles"), number("compression"), number("seconds")));
    if (study == "pressure")
      columns[scene].first += number("measured"), columns[scene].second += number("ideal");
  }
  for (const auto& [scene, sums] : columns)
    context.note(
        fmt::format("Column of {}: mean pressure {:.3f} of the weight.", scene, sums.first / sums.second));
  const auto [least, most] = std::minmax_element(limit.begin(), limit.end());
  const auto [low, high] = std::minmax_element(rule.begin(), rule.end());
  if (!limit.empty())
    context.note(
        fmt::format("The step limit lies at {:.2f} to {:.2f} times the predicted one, at {:.2f} to {:.2f} "
                    "times 0.4 h / c.",
                    *least, *most, *low, *high));
  if (!count.empty())
    context.note(
        fmt::format("{:.2g} particle updates per second and thread at {:.0f} particles; time grows with the "
                    "power {:.2f} of their number.",
                    count.back() / seconds.back(), count.back(), fit_power(count, seconds).slope));
}

void body(Context& context) {
  const Settings& settings = context.settings;
  struct Study {
    const char* list;
    void (*run)(Context&, double);
  };
  const Study studies[] = {
      {"viscosities", [](Context& c, double x) { study_limit(c, "limit", x, 3.0); }},
      {"supports", [](Context& c, double x) { study_limit(c, "limit_support", 10.0, x); }},
      {"particles", study_cost},
      {"column_layers", [](Context& c, double x) { study_pressure(c, static_cast<int>(x)); }},
      {"box_sides", [](Context& c, double x) { study_float(c, static_cast<int>(x)); }},
      {"dam_layers", [](Context& c, double x) { study_front(c, static_cast<int>(x)); }},
      {"projection_layers", [](Context& c, double x) { study_projection(c, static_cast<int>(x)); }},
  };
  long parts = 0;
  for (const Study& study : studies) parts += std::ssize(settings.numbers(study.list));
  context.progress.start(parts);
  for (const Study& study : studies)
    for (double value : settings.numbers(study.list))
      if (!context.interrupted()) {
        study.run(context, value);
        context.progress.advance(fmt::format("{} {:g}", study.list, value));
      }
  add_charts(context);
  note_all(context);
}

}  // namespace
}  // namespace feder::experiments

int main(int argc, char** argv) {
  return feder::experiments::run_experiment(feder::experiments::kInfo, argc, argv, feder::experiments::body);
}
