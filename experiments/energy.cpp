// Where does the energy go? Ledgers (engine/energy.h) over many steps, beside the energy of the states
// themselves.
//   per step:  dK = external + drag + rows + geometric + numerical, closing to rounding
//   per run:   E(end) - E(0) = external work - force.dq + drag + (row work + dU) + geometric + numerical
//   leapfrog:  the energy error is bounded and has no trend
// Trend: least squares over the means of kBlocks blocks, which are much longer than the oscillations.
#include <fmt/format.h>

#include <cmath>

#include "engine/check.h"
#include "experiments/support/experiment.h"
#include "experiments/support/measure.h"
#include "models/bending_rod.h"
#include "models/cloth.h"
#include "models/spring_pendulum.h"
#include "solvers/simulate.h"

namespace feder::experiments {
namespace {

constexpr std::size_t kBlocks = 20;    // of the trend
constexpr std::size_t kWindows = 100;  // points of a curve
constexpr double kRounding = 1e-12;    // imbalance of a step, relative, that still counts as rounding

const ExperimentInfo kInfo{
    .name = "energy",
    .question = "Which integrator gains or loses how much energy, and does its ledger say where it went?",
    .not_modelled =
        "Time steps near the stability limit (see stability) and the accuracy of the motion (see "
        "convergence).",
    .settings = {{"scenes",
                  Kind::kTexts,
                  "spring_pendulum,net,damped_net,rod",
                  "spring_pendulum,net,damped_net,rod",
                  "scenes",
                  {"spring_pendulum", "net", "damped_net", "rod"}},
                 {"steps", Kind::kInteger, "10000", "100000", "steps of every run, at least 1000"},
                 {"net", Kind::kInteger, "4", "6", "nodes along an edge of the nets"},
                 {"net_stiffness", Kind::kNumber, "1000", "1000", "springs of the nets, N/m"},
                 {"rod", Kind::kInteger, "8", "20", "nodes of the rod of hard links"}},
    .columns =
        {"scene",          "integrator",   "route",        "dt",        "status",      "reason",
         "steps",          "energy_drift", "jitter",       "trend",     "trend_error", "external",
         "drag",           "rows",         "geometric",    "numerical", "books_gap",   "worst_imbalance",
         "worst_rounding", "energy_scale", "scene_length", "seconds"},
    .cases = {"spring_pendulum", "net", "damped_net", "rod"}};

// ---- Scenes

struct Scene {
  std::string name, title;
  Model model;
  double dt;  // [s]
  bool conserves;
};

Cloth net(const Settings& settings) {
  const double d = settings.number("net_stiffness");
  return {.n = static_cast<int>(settings.integer("net")),
          .stiffness = d,
          .shear_stiffness = d,
          .bend_stiffness = 0.1 * d};
}

// A tenth of 1 / omega of a node held by eight springs.
double net_step(const Cloth& options) {
  const double node = options.mass / (options.n * options.n);
  return 0.1 / std::sqrt(8.0 * options.stiffness / node);
}

Scene make_scene(const std::string& name, const Settings& settings) {
  if (name == "spring_pendulum")
    return {name, "spring pendulum, undamped", make_spring_pendulum({.elongation = 0.01}), 1e-3, true};
  Cloth cloth = net(settings);
  const double dt = net_step(cloth);
  if (name == "net") return {name, "net, undamped", make_cloth(cloth), dt, true};
  if (name == "damped_net") {
    cloth.damping_time = 1e-3;
    cloth.drag = 0.1 * cloth.mass / (cloth.n * cloth.n);
    return {name, "net, row damping and drag", make_cloth(cloth), dt, false};
  }
  const BendingRod rod{.n = static_cast<int>(settings.integer("rod")),
                       .axial_stiffness = std::numeric_limits<double>::infinity(),
                       .gravity = 9.81,
                       .damping_time = 1e-3};
  return {name, "rod: hard links, damped bending", make_bending_rod(rod), 5e-4, false};
}

// ---- One run

struct Books {
  Status status;
  std::vector<double> time, energy;  // after every step, the start included
  EnergyLedger sum;
  double magnitude = 0.0, seconds = 0.0;
  double worst_imbalance = 0.0;  // of a step, against the magnitude of its terms
  double worst_rounding = 0.0;   // the same, against the kinetic energies that it subtracts as well
  double external_change = 0.0;  // of the potential of constant forces [J]

  std::size_t steps() const { return time.size() - 1; }
  double change() const { return energy.back() - energy.front(); }
  double rows() const { return sum.row_work + sum.row_change; }
  // E(end) - E(0) as the ledger has it
  double booked() const {
    return sum.external_work + external_change + sum.drag_work + rows() + sum.geometric_work + sum.numerical +
           sum.contact_work;
  }
};

void add(Books& books, const EnergyLedger& step, double kinetic) {
  books.sum.kinetic_change += step.kinetic_change;
  books.sum.row_change += step.row_change;
  books.sum.external_work += step.external_work;
  books.sum.drag_work += step.drag_work;
  books.sum.row_work += step.row_work;
  books.sum.geometric_work += step.geometric_work;
  books.sum.numerical += step.numerical;
  books.sum.contact_work += step.contact_work;
  const double magnitude = step.magnitude();
  books.magnitude += magnitude;
  if (!(magnitude > 0.0)) return;
  const double imbalance = std::abs(step.imbalance());
  books.worst_imbalance = std::max(books.worst_imbalance, imbalance / magnitude);
  books.worst_rounding = std::max(books.worst_rounding, imbalance / (magnitude + kinetic));
}

Books keep_books(const Scene& scene, const std::string& name, std::int64_t steps) {
  const System& system = scene.model.system;
  Integrator integrator = make_integrator(name, system);
  State state = scene.model.state;
  History history;
  std::vector<EnergyLedger> ledgers;
  Books books;
  books.time = {0.0};
  books.energy = {total_energy(system, state)};
  double external = external_energy(system, state);
  const double external_start = external;

  RunOptions options;
  options.dt = scene.dt;
  options.end_time = scene.dt * static_cast<double>(steps);
  options.ledgers = &ledgers;
  options.observer = [&](const State& now, const History&) {
    add(books, ledgers.back(), kinetic_energy(system, now));
    ledgers.clear();
    external = external_energy(system, now);
    books.time.push_back(now.t);
    books.energy.push_back(total_energy(system, now));
    return true;
  };
  RunResult run = simulate(system, integrator, state, history, options);
  books.status = std::move(run.status);
  books.seconds = run.seconds;
  books.external_change = external - external_start;
  return books;
}

// ---- Trend and jitter

struct Trend {
  Line line;                                   // of the energy error over time [J/s]
  double jitter = 0.0;                         // rms about the line [J]
  double first_half = 0.0, second_half = 0.0;  // largest |E - E(0)| [J]
};

Trend trend_of(const Books& books) {
  std::vector<double> time, mean;
  const std::size_t length = books.time.size() / kBlocks;
  for (std::size_t block = 0; length > 0 && block < kBlocks; ++block) {
    double t = 0.0, e = 0.0;
    for (std::size_t i = block * length; i < (block + 1) * length; ++i)
      t += books.time[i], e += books.energy[i] - books.energy[0];
    time.push_back(t / static_cast<double>(length));
    mean.push_back(e / static_cast<double>(length));
  }
  Trend trend{fit_line(time, mean)};
  for (std::size_t i = 0; i < books.time.size(); ++i) {
    const double error = books.energy[i] - books.energy[0];
    trend.jitter += std::pow(error - trend.line.offset - trend.line.slope * books.time[i], 2);
    double& peak = 2 * i < books.time.size() ? trend.first_half : trend.second_half;
    peak = std::max(peak, std::abs(error));
  }
  trend.jitter = std::sqrt(trend.jitter / static_cast<double>(books.time.size()));
  return trend;
}

// ---- Rows, charts, conclusions

Cell cell(double value) {
  return std::isfinite(value) ? Cell(value) : Cell();
}

void add_row(Context& context, const Scene& scene, const IntegratorInfo& method, const Books& books) {
  const double scale = energy_scale(scene.model);
  Table::Row row{{"scene", scene.name},
                 {"integrator", method.name},
                 {"route", takes_routes(method) ? "auto" : "none"},
                 {"dt", scene.dt},
                 {"status", to_string(books.status.code)},
                 {"reason", books.status.reason},
                 {"steps", static_cast<std::int64_t>(books.steps())},
                 {"energy_scale", scale},
                 {"scene_length", scene.model.scene_length},
                 {"seconds", books.seconds}};
  if (books.steps() > 0) {
    const Trend trend = trend_of(books);
    const Table::Row numbers{{"energy_drift", cell(books.change() / scale)},
                             {"jitter", cell(trend.jitter / scale)},
                             {"trend", cell(trend.line.slope / scale)},
                             {"trend_error", cell(trend.line.slope_error / scale)},
                             {"external", cell(books.sum.external_work)},
                             {"drag", cell(books.sum.drag_work)},
                             {"rows", cell(books.rows())},
                             {"geometric", cell(books.sum.geometric_work)},
                             {"numerical", cell(books.sum.numerical)},
                             {"books_gap", cell(std::abs(books.change() - books.booked()) / books.magnitude)},
                             {"worst_imbalance", cell(books.worst_imbalance)},
                             {"worst_rounding", cell(books.worst_rounding)}};
    row.insert(row.end(), numbers.begin(), numbers.end());
  }
  context.table.add(row);
}

// Conserving scenes: largest |E - E0| per window, on a log axis; the others: E - E0.
Series curve(const Scene& scene, const IntegratorInfo& method, const Books& books) {
  Series series{.label = method.name, .markers = false};
  const double scale = energy_scale(scene.model);
  const std::size_t length = std::max<std::size_t>(1, books.steps() / kWindows);
  for (std::size_t begin = 1; begin < books.time.size(); begin += length) {
    const std::size_t end = std::min(begin + length, books.time.size());
    double peak = 0.0;
    for (std::size_t i = begin; i < end; ++i)
      peak = std::max(peak, std::abs(books.energy[i] - books.energy[0]));
    const double last = books.energy[end - 1] - books.energy[0];
    series.add(books.time[end - 1], (scene.conserves ? peak : last) / scale);
  }
  if (!books.status.ok()) series.failed_x = {books.time.back()};
  return series;
}

Panel make_panel(const Scene& scene) {
  return {.title = scene.title,
          .x = {"time t [s]", false},
          .y = {scene.conserves ? "largest |E - E(0)| / energy scale [1]" : "(E - E(0)) / energy scale [1]",
                scene.conserves,
                {},
                scene.conserves ? std::optional(10.0) : std::nullopt}};
}

void note_books(Context& context, const Scene& scene, const IntegratorInfo& method, const Books& books) {
  if (!books.status.ok()) return;
  const Trend trend = trend_of(books);
  const double scale = energy_scale(scene.model);
  if (method.symmetric && scene.conserves)
    context.note(fmt::format(
        "{}, {}: largest energy error {:.2e} in the first half of {} steps, {:.2e} in the second; trend "
        "({:.1e} +- {:.1e})/s, {:.1f} standard errors from zero.",
        scene.name, method.name, trend.first_half / scale, books.steps(), trend.second_half / scale,
        trend.line.slope / scale, trend.line.slope_error / scale,
        std::abs(trend.line.slope) / trend.line.slope_error));
  if (method.implicit && scene.conserves)
    context.note(
        fmt::format("{}, {}: lost {:.6g} J; the ledger explains {:.6g} J ({:.3g} numerical, {:.3g} "
                    "geometric, {:.3g} in the rows).",
                    scene.name, method.name, -books.change(), -books.booked(), -books.sum.numerical,
                    0.0 - books.sum.geometric_work, 0.0 - books.rows()));
}

double largest(const Table& table, const char* column) {
  double value = 0.0;
  for (std::size_t row = 0; row < table.rows(); ++row)
    value = std::max(value, table.at(row, column).number());  // an empty cell is NaN and loses
  return value;
}

void note_worst(Context& context) {
  const double rounding = largest(context.table, "worst_rounding");
  context.note(fmt::format(
      "Worst imbalance of a single step: {:.1e} of its terms, {:.1e} of terms and kinetic energy, {}. "
      "Ledgers and states agree to {:.1e} over whole runs.",
      largest(context.table, "worst_imbalance"), rounding,
      rounding < kRounding ? "which is rounding" : "more than rounding",
      largest(context.table, "books_gap")));
}

void study(Context& context, const Scene& scene, Chart& chart) {
  Panel panel = make_panel(scene);
  for (const IntegratorInfo& method : integrator_list()) {
    if (context.interrupted()) return;
    const Books books = keep_books(scene, method.name, context.settings.integer("steps"));
    add_row(context, scene, method, books);
    note_books(context, scene, method, books);
    if (books.status.code != StatusCode::kRefused) panel.series.push_back(curve(scene, method, books));
    context.progress.advance(scene.name + " " + method.name);
  }
  panel.series = with_integrator_looks(std::move(panel.series));
  chart.panels.push_back(std::move(panel));
}

void require_in_range(const Settings& settings) {
  if (const std::int64_t steps = settings.integer("steps"); steps < 1000)
    throw InputError(fmt::format("setting 'steps': got {}, expected at least 1000", steps));
}

void body(Context& context) {
  const std::vector<std::string> names = context.settings.texts("scenes");
  require_in_range(context.settings);
  Chart chart{
      .name = "energy",
      .title = "Energy over many steps",
      .caption =
          "Undamped: the energy error of a symmetric method stays bounded, that of the others grows. Damped: "
          "implicit Euler adds its own dissipation to that of the dampers, explicit Euler takes from it. "
          "While a "
          "net still fills its fast modes, the bounded error of leapfrog still rises with them."};
  context.progress.start(static_cast<long>(names.size() * integrator_list().size()));
  std::vector<Scene> scenes;  // all of them first: bad input is found before the first step
  for (const std::string& name : names) scenes.push_back(make_scene(name, context.settings));
  for (const Scene& scene : scenes) study(context, scene, chart);
  context.add_chart(std::move(chart));
  note_worst(context);
}

}  // namespace
}  // namespace feder::experiments

int main(int argc, char** argv) {
  return feder::experiments::run_experiment(feder::experiments::kInfo, argc, argv, feder::experiments::body);
}
