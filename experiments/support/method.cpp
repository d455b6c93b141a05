#include "experiments/support/method.h"

#include <cmath>
#include <memory>

#include "engine/check.h"
#include "solvers/integrators.h"
#include "solvers/linear/linear_solver.h"

namespace feder::experiments {
namespace {

struct MethodEntry : Entry {
  int integrator = 0, route = 0, rotation_update = 0;
  double dt = 0.0, tolerance = 0.0, newton_tolerance = IntegratorOptions{}.newton_tolerance;
  double max_seconds = 0.0, divergence = 1e6;
  int most_newton_iterations = IntegratorOptions{}.most_newton_iterations;
  int sweeps = IntegratorOptions{}.sweeps, substeps = IntegratorOptions{}.substeps;
};
constexpr double kMostSteps = 9007199254740992.0;
struct OutputEntry : Entry {
  double interval = 0.0;
  std::vector<double> times = {};
  std::vector<std::string> files = Output{}.files;
  int checkpoint_frames = 0;
};

std::vector<std::string> integrators() {
  std::vector<std::string> names = {"auto"};
  for (const IntegratorInfo& info : integrator_list()) names.emplace_back(info.name);
  return names;
}

std::vector<std::string> routes() {
  std::vector<std::string> names = route_names();
  names.insert(names.begin(), "auto");
  return names;
}

const Keys<MethodEntry>& method_keys() {
  using E = MethodEntry;
  static const Keys<E> list = {
      choice_key("integrator", &E::integrator, "auto",
                 "simulate --list says what they are; auto takes what --explain recommends", integrators()),
      choice_key("route", &E::route, "auto", "how the implicit ones solve their linear systems", routes()),
      key<E>("dt", &E::dt, "as --explain says", "s",
             "largest step; steps between two output times are equal, so they may be a little shorter",
             kPositive),
      key<E>("tolerance", &E::tolerance, "", "m",
             "error the places may have: steps are then controlled by step doubling, and dt is the first",
             kPositive),
      choice_key("rotation_update", &E::rotation_update, "exponential",
                 "how bodies turn, of explicit_euler, implicit_euler_notes and implicit_euler_geometric",
                 {"exponential", "normalised_euler"}),
      key<E>("newton_tolerance", &E::newton_tolerance, "1e-14", "",
             "relative residual at which implicit_euler_newton is done with a step", Range{0.0, 1.0, true}),
      key<E>("most_newton_iterations", &E::most_newton_iterations, "200", "",
             "in one step of implicit_euler_newton", Range{1.0, 1e6, false, false, true}),
      key<E>("sweeps", &E::sweeps, "20", "", "over the rows in one substep of xpbd",
             Range{1.0, 1e6, false, false, true}),
      key<E>("substeps", &E::substeps, "1", "", "equal parts of one step of xpbd",
             Range{1.0, 1e6, false, false, true}),
      key<E>("max_seconds", &E::max_seconds, "none", "s",
             "wall time after which a run is given up as limit_reached", kPositive),
      key<E>("divergence", &E::divergence, "1e6", "",
             "kinetic energy, in units of the scene's, that ends a run as diverged", Range{1.0, 1e300}),
  };
  return list;
}

const Keys<OutputEntry>& output_keys() {
  using E = OutputEntry;
  static const Keys<E> list = {
      key<E>("interval", &E::interval, "a hundredth of the run", "s", "between two frames, or times",
             kPositive),
      key<E>("times", &E::times, "", "s",
             "of the frames instead of an interval; start and end are always there", kPositive),
      words_key("files", &E::files, "[\"states\", \"energy\"]", "see Results", output_files()),
      key<E>("checkpoint_frames", &E::checkpoint_frames, "about 200 steps", "",
             "frames from one checkpoint.bin, for --resume, to the next",
             Range{1.0, 1e9, false, false, true}),
  };
  return list;
}

}  // namespace

const std::vector<std::string>& output_files() {
  static const std::vector<std::string> words = {"states", "trajectory", "npy", "rows", "energy", "vtu"};
  return words;
}

std::vector<TableInfo> method_tables() {
  return {{"method", "How the scene is advanced.", false, infos(method_keys())},
          {"output", "When to look, and what to write down.", false, infos(output_keys())}};
}

std::vector<OtherTable> method_readers(Method& method, Output& output) {
  const auto dt_place = std::make_shared<TextPlace>();
  auto read_method = [&method, dt_place](const Value& table, Diagnostics& problems) {
    MethodEntry entry;
    if (const Value* dt = table.find("dt")) *dt_place = dt->place;
    read_entry(table, method_keys(), infos(method_keys()), "method", entry, problems);
    method.integrator = integrators()[static_cast<std::size_t>(entry.integrator)];
    method.dt = entry.dt, method.tolerance = entry.tolerance;
    method.max_seconds = entry.max_seconds, method.divergence = entry.divergence;
    method.options.route = routes()[static_cast<std::size_t>(entry.route)];
    method.options.rotation_update =
        entry.rotation_update == 0 ? RotationUpdate::kExponential : RotationUpdate::kNormalisedEuler;
    method.options.newton_tolerance = entry.newton_tolerance;
    method.options.most_newton_iterations = entry.most_newton_iterations;
    method.options.sweeps = entry.sweeps, method.options.substeps = entry.substeps;
  };
  const auto place = std::make_shared<TextPlace>();
  auto read_output = [&output, place](const Value& table, Diagnostics& problems) {
    OutputEntry entry;
    for (const char* key : {"interval", "times"})
      if (const Value* value = table.find(key)) *place = value->place;
    read_entry(table, output_keys(), infos(output_keys()), "output", entry, problems);
    if (const Value* times = table.find("times"); times && table.find("interval"))
      problems.add(times->place, "output: it has both interval and times, expected one");
    output = {entry.interval, entry.times, entry.files, entry.checkpoint_frames};
  };
  auto check_output = [&output, place](double end_time, Diagnostics& problems) {
    try {
      require_frames(output, end_time);
    } catch (const InputError& error) {
      problems.add(*place, error.what());
    }
  };
  auto check_method = [&method, dt_place](double end_time, Diagnostics& problems) {
    if (method.dt > 0.0 && !(end_time / method.dt <= kMostSteps))
      problems.add(*dt_place,
                   "method: dt = " + to_text(method.dt) +
                       " s, expected a step that the clock can resolve, at most 2^53 of them up to " +
                       to_text(end_time) + " s");
  };
  return {{"method", read_method, check_method}, {"output", read_output, check_output}};
}

void require_frames(const Output& output, double end_time) {
  double before = 0.0;
  for (const double t : output.times) {
    if (!(t > before) || t > end_time)
      fail_input("output", "time", t, "s", "ascending times up to the end, " + to_text(end_time) + " s");
    before = t;
  }
  if (output.interval > 0.0 && !(end_time / output.interval <= kMostFrames))
    fail_input("output", "interval", output.interval, "s", "at most 1e7 frames");
}

std::vector<double> frame_times(const Output& output, double end_time) {
  require_frames(output, end_time);
  std::vector<double> times = {0.0};
  if (!output.times.empty()) {
    times.insert(times.end(), output.times.begin(), output.times.end());
    if (times.back() < end_time) times.push_back(end_time);
    return times;
  }
  const double interval = output.interval > 0.0 ? output.interval : end_time / 100.0;
  const double count = end_time / interval;
  const auto whole = static_cast<std::int64_t>(std::floor(count + 1e-9));
  for (std::int64_t k = 1; k <= whole; ++k) times.push_back(static_cast<double>(k) * interval);
  if (whole >= 1 && std::abs(times.back() - end_time) <= 1e-9 * interval)
    times.back() = end_time;
  else
    times.push_back(end_time);
  return times;
}

}  // namespace feder::experiments
