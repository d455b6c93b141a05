// A scene file, run by any method, its motion written as data.

#include <fmt/format.h>

#include <cstdio>
#include <optional>

#include "experiments/support/explain.h"
#include "experiments/support/hash.h"
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

  Model& model() { return file.scene.model; }
};

Task read_task(const SimulateOptions& options, const std::filesystem::path& folder) {
  Task task;
  const SceneOptions how{.changes = options.changes,
                         .others = method_readers(task.method, task.output),
                         .quick = options.preset == "quick",
                         .allow_outside = options.allow_outside};
  task.text = read_scene_bytes(options.scene);
  task.file = read_scene_text(task.text, options.scene.string(), folder, how);
  (void)frame_times(task.output, task.model().end_time);
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
  return fmt::format("{}: {} particles and points, {} bodies, {} rows, {} unknowns, {} s", scene.model.name,
                     scene.nodes.size() - s.bodies.size(), s.bodies.size(), scene.rows.size(), s.free_count,
                     scene.model.end_time);
}

std::string hash_of(const Task& task, const SimulateOptions& options) {
  std::string all = task.text + "\n" + options.preset;
  for (const std::string& change : options.changes) all += "\n" + change;
  return text_hash(all);
}

void say(const SimulateOptions& options, const std::string& line) {
  if (!options.quiet) fmt::print("{}\n", line);
}

void say_results(const SimulateOptions& options, const RunReport& report, const Reference* judge,
                 const Scene& scene) {
  say(options,
      fmt::format("{} on route {}: {} steps of at most {:.4g} s to t = {:.6g} s in {:.3g} s, {} frames",
                  report.integrator, report.route, report.steps, report.dt, report.state.t, report.seconds,
                  report.frames));
  if (report.status.ok())
    say(options, fmt::format("energy drift {:.3g} of the scene's scale", report.energy_drift));
  if (judge)
    say(options, fmt::format("error {:.3g} m, the judge's own {:.2g} m ({})",
                             position_error(scene.model.system, report.state, judge->state), judge->error,
                             judge->method));
  say(options, fmt::format("Results are in {}", options.out.string()));
}

// Runs a task; `hash` becomes that of its results.
Ending simulate_scene(const SimulateOptions& options, Task& task, std::string& hash) {
  const auto started = std::chrono::system_clock::now();
  const Stopwatch watch;
  create_folder(options.out);
  set_threads(options.threads);
  resolve(task);
  const Scene& scene = task.file.scene;
  const RunRequest request{
      scene,         task.method, task.output, options.out, std::stoull(hash_of(task, options), nullptr, 16),
      options.resume};
  write_file(options.out / kSceneCopy, task.text);
  Progress progress(options.quiet);
  const RunReport report = run_scene(request, progress);
  progress.clear();
  Ending ending = ending_of(report.status);
  std::optional<Reference> judge;
  if (options.reference && ending.code == 0) {
    judge = make_reference(scene.model.system, scene.model.state, scene.model.end_time);
    if (!judge->status.ok())
      ending = ending_of(judge->status), ending.reason = "judge: " + ending.reason, judge.reset();
  }
  write_file(options.out / "manifest.json",
             manifest_json({options, task.method, scene, text_hash(task.text), report,
                            judge ? &*judge : nullptr, ending, started, watch.seconds()}));
  say_results(options, report, judge ? &*judge : nullptr, scene);
  hash = results_hash(report);
  return ending;
}

Ending rerun(const SimulateOptions& given) {
  const Rerun again = read_rerun(given);
  Task task = read_task(again.options, again.folder);
  std::string now;
  const std::string before = again.results_hash;
  const Ending ending = simulate_scene(again.options, task, now);
  if (ending.code != 0) return ending;
  if (now != before)
    return ending_of(
        Status::failure(StatusCode::kInconsistent, "results hash " + now + ", the manifest says " + before));
  say(given, "The results are bitwise those of the manifest.");
  return ending;
}

int list_methods() {
  for (const IntegratorInfo& info : integrator_list())
    fmt::print("integrator {:<26} {}\n", info.name, info.summary);
  for (const std::string& name : route_names()) fmt::print("route {}\n", name);
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
  const std::filesystem::path folder =
      options->scene.has_parent_path() ? options->scene.parent_path() : std::filesystem::path(".");
  Task task = read_task(*options, folder);
  if (options->validate) {
    say(*options, summary(task) + ": no problems");
    return {};
  }
  if (options->explain) {
    std::fputs(to_text(explain(task.model(), task.method.dt)).c_str(), stdout);
    return {};
  }
  if (options->dry_run) {
    resolve(task);
    fmt::print("{}\nintegrator {}, route {}, dt {} s, {} frames into {}\n", summary(task),
               task.method.integrator, task.method.options.route, task.method.dt,
               frame_times(task.output, task.model().end_time).size(), options->out.string());
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
