// A scene file, run by any method, its motion written as data.

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <optional>

#include "engine/energy.h"
#include "experiments/support/explain.h"
#include "experiments/support/hash.h"
#include "experiments/support/measure.h"
#include "experiments/support/simulate_manifest.h"
#include "experiments/support/timing.h"
#include "solvers/integrators.h"
#include "solvers/threads.h"

namespace {

using namespace feder;
using namespace feder::experiments;

// A scene with everything that decides its run.
struct Task {
  SceneFile file;
  Method method;
  Output output;
  std::string text;
  std::filesystem::path path;  ///< of the scene; its folder is where mesh files are

  Model& model() { return file.scene.model; }
};

// `path` is where the scene came from if options.scene is a copy.
Task read_task(const SimulateOptions& options, const std::filesystem::path& path) {
  Task task;
  task.path = path;
  const SceneOptions how{.changes = options.changes,
                         .others = method_readers(task.method, task.output),
                         .quick = options.preset == "quick",
                         .allow_outside = options.allow_outside};
  task.text = read_scene_bytes(options.scene);
  task.file =
      read_scene_text(task.text, path.string(), path.has_parent_path() ? path.parent_path() : ".", how);
  const std::vector<double> times = frame_times(task.output, task.model().end_time);
  if (task.method.dt > 0.0) require_steps(task.method, times);
  return task;
}

// What the file leaves open is what `explain` recommends.
void resolve(Task& task) {
  Method& method = task.method;
  if (method.integrator != "auto" && method.dt > 0.0) return;
  const Recommendation advice = explain(task.model(), method.dt).recommended;
  if (method.integrator == "auto")
    method.integrator = advice.integrator.empty() ? "leapfrog" : advice.integrator;
  if (!(method.dt > 0.0)) method.dt = advice.dt > 0.0 ? advice.dt : task.model().end_time;
}

std::string summary(Task& task) {
  const Scene& scene = task.file.scene;
  const System& s = scene.model.system;
  int scalars = 0;
  for (const SceneRow& row : scene.rows) scalars += row.rows;
  return fmt::format("{}: {} particles and points, {} bodies, {} rows ({} scalar), {} unknowns, {} s",
                     scene.model.name, scene.nodes.size() - s.bodies.size(), s.bodies.size(),
                     scene.rows.size(), scalars, s.free_count, scene.model.end_time);
}

std::string hash_of(const Task& task, const SimulateOptions& options) {
  std::string all = task.text + "\n" + options.preset;
  for (const std::string& change : options.changes) all += "\n" + change;
  return text_hash(all);
}

// Also what takes a look at the rank: a mechanism that cannot move.
std::vector<std::string> all_notes(Task& task) {
  constexpr int kMostRows = 2000;  // explain looks at far more than the rank
  std::vector<std::string> notes = task.file.notes;
  const System& s = task.model().system;
  if (s.has_hard_rows && !s.driven() && s.rows <= kMostRows && explain(task.model()).degrees_of_freedom == 0)
    notes.emplace_back("nothing can move: the rigid rows leave no degree of freedom");
  return notes;
}

// A reader that went away costs the line, not the run.
void say(const SimulateOptions& options, const std::string& line) {
  if (!options.quiet) std::fputs((line + "\n").c_str(), stdout);
}

void say_results(const SimulateOptions& options, const RunReport& report, const Reference* judge,
                 const Scene& scene) {
  say(options,
      fmt::format("{}{}: {} steps{}, to t = {:.6g} s, {} frames; {:.3g} s of stepping, {:.3g} s of output",
                  report.integrator, report.route == "none" ? "" : " on route " + report.route, report.steps,
                  std::isnan(report.dt) ? "" : fmt::format(" of at most {:.4g} s", report.dt), report.state.t,
                  report.frames, report.seconds, report.seconds_output));
  if (report.status.ok()) {
    const Model& model = scene.model;
    say(options,
        fmt::format("energy {:.7g} to {:.7g} J: changed by {:.3g} of the scene's scale of {:.3g} J{}",
                    total_energy(model.system, model.state), total_energy(model.system, report.state),
                    report.energy_drift, energy_scale(model),
                    model.conserved.empty() ? "" : " (it should keep it)"));
  }
  if (judge)
    say(options, fmt::format("error {:.3g} m against the judge, whose own is {:.2g} m ({})",
                             position_error(scene.model.system, report.state, judge->state), judge->error,
                             judge->method));
  say(options, fmt::format("Results are in {}", options.out.string()));
}

// The manifest, too, may find the disk full: what the run says comes first.
void write_manifest(const std::filesystem::path& folder, const std::string& text, const Ending& ending) {
  try {
    write_file(folder / "manifest.json", text);
  } catch (const IoError&) {
    if (ending.code == 0) throw;
  }
}

// Runs a task; `hash` becomes that of its results.
Ending simulate_scene(const SimulateOptions& options, Task& task, std::string& hash) {
  const auto started = std::chrono::system_clock::now();
  const Stopwatch watch;
  set_threads(options.threads);
  resolve(task);
  const Scene& scene = task.file.scene;
  require_steps(task.method, frame_times(task.output, scene.model.end_time));
  const RunRequest request{
      scene,         task.method, task.output, options.out, std::stoull(hash_of(task, options), nullptr, 16),
      options.resume};
  if (!options.resume) {
    create_folder(options.out);
    write_file(options.out / kSceneCopy, task.text);
    remove_file(options.out / "manifest.json");  // of an earlier run, whose files are about to be replaced
  }
  Progress progress(options.quiet);
  const RunReport report = run_scene(request, progress);
  progress.clear();
  Ending ending = ending_of(report.status);
  std::optional<Reference> judge;
  auto write = [&] {
    write_manifest(
        options.out,
        manifest_json({options, task.path, task.output, task.method, scene, text_hash(task.text), report,
                       judge ? &*judge : nullptr, ending, task.file.notes, started, watch.seconds()}),
        ending);
  };
  write();
  if (options.reference && ending.code == 0) {
    judge = make_reference(scene.model.system, scene.model.state, scene.model.end_time);
    if (!judge->status.ok())
      ending = ending_of(judge->status), ending.reason = "judge: " + ending.reason, judge.reset();
    write();
  }
  say_results(options, report, judge ? &*judge : nullptr, scene);
  hash = results_hash(report);
  return ending;
}

Ending rerun(const SimulateOptions& given) {
  const Rerun again = read_rerun(given);
  Task task = read_task(again.options, again.file);
  std::string now;
  const std::string before = again.results_hash;
  const Ending ending = simulate_scene(again.options, task, now);
  if (ending.code == 4 || ending.code == 130) return ending;
  if (now != before)
    return ending_of(
        Status::failure(StatusCode::kInconsistent, "results hash " + now + ", the manifest says " + before));
  say(given, "The results are bitwise those of the manifest.");
  return ending;
}

int list_methods() {
  for (const IntegratorInfo& info : integrator_list())
    std::fputs(fmt::format("integrator {:<26} {}\n", info.name, info.summary).c_str(), stdout);
  for (const std::string& name : route_names()) std::fputs(("route " + name + "\n").c_str(), stdout);
  return 0;
}

Ending run(int argc, char** argv) {
  std::optional<SimulateOptions> options = parse_simulate(argc, argv);
  if (!options) return {};
  if (options->list) return {list_methods()};
  if (options->keys) {
    std::fputs(scene_reference(method_tables()).c_str(), stdout);
    return {};
  }
  if (!options->rerun.empty()) return rerun(*options);
  Task task = read_task(*options, options->scene);
  if (options->validate) {
    say(*options, summary(task) + ": no problems");
    for (const std::string& note : all_notes(task)) say(*options, "note: " + note);
    return {};
  }
  for (const std::string& note : task.file.notes) say(*options, "note: " + note);
  if (options->explain) {
    std::fputs(to_text(explain(task.model(), task.method.dt)).c_str(), stdout);
    return {};
  }
  if (options->dry_run) {
    resolve(task);
    say(*options, summary(task));
    say(*options, fmt::format("integrator {}, route {}, dt {} s, {} frames into {}", task.method.integrator,
                              task.method.options.route, task.method.dt,
                              frame_times(task.output, task.model().end_time).size(), options->out.string()));
    return {};
  }
  std::string hash;
  return simulate_scene(*options, task, hash);
}

}  // namespace

int main(int argc, char** argv) {
  restart_with_better_blas(argv);
  fix_environment();
  return report("simulate", guarded([&] { return run(argc, argv); }));
}
