#include "experiments/support/scene_run.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/energy.h"
#include "experiments/support/files.h"
#include "experiments/support/interrupt.h"
#include "experiments/support/measure.h"
#include "experiments/support/timing.h"
#include "solvers/simulate.h"

namespace feder::experiments {
namespace {

constexpr double kStepsPerCheckpoint = 200.0;

FrameOptions frame_options(const Output& output) {
  auto asked = [&](const char* word) {
    return std::find(output.files.begin(), output.files.end(), word) != output.files.end();
  };
  return {.states = asked("states"),
          .trajectory_csv = asked("trajectory"),
          .trajectory_npy = asked("npy"),
          .rows = asked("rows"),
          .energy = asked("energy"),
          .vtu = asked("vtu")};
}

// Equal steps of at most dt that fill the span; dt itself where it does up to rounding.
double equal_step(double span, double dt) {
  const double steps = std::max(1.0, std::ceil(span / dt - 1e-9)), step = span / steps;
  return std::abs(step - dt) <= 1e-9 * dt ? std::min(dt, span) : step;
}

class Run {
 public:
  Run(const RunRequest& request, Progress& progress)
      : request_(request),
        system_(request.scene.model.system),
        times_(frame_times(request.output, request.scene.model.end_time)),
        check_(system_, request.scene.model.state, times_.back(), request.method.divergence),
        progress_(progress) {
    const double per_frame = std::ceil((times_[1] - times_[0]) / request.method.dt);
    every_ =
        request.output.checkpoint_frames > 0
            ? request.output.checkpoint_frames
            : static_cast<std::int64_t>(std::clamp(std::ceil(kStepsPerCheckpoint / per_frame), 1.0, 1e9));
    report_.state = request.scene.model.state;
    report_.integrator = request.method.integrator;
  }

  RunReport go() {
    const auto count = static_cast<std::int64_t>(times_.size());
    const FrameOptions options = frame_options(request_.output);
    if (request_.resume) {
      const std::filesystem::path path = request_.folder / kCheckpointFile;
      const Checkpoint checkpoint = read_checkpoint(path);
      require_checkpoint_of(request_.scene, request_.scene_hash, checkpoint, path.string());
      report_.state = checkpoint.state, history_ = checkpoint.history, report_.steps = checkpoint.step;
      files_.emplace(request_.scene, count, request_.folder, options, checkpoint);
    } else {
      remove_file(request_.folder / kCheckpointFile);  // it belongs to other files
      files_.emplace(request_.scene, count, request_.folder, options);
      write(0);
      save();
    }
    progress_.start(static_cast<long>(count - files_->frames()));
    try {
      while (files_->frames() < count && report_.status.ok()) next_frame();
    } catch (const IoError&) {
      close_quietly();
      throw;
    }
    collect_times();
    files_->finish();
    report_.frames = files_->frames();
    if (report_.status.ok()) {
      const Model& model = request_.scene.model;
      report_.energy_drift =
          (total_energy(system_, report_.state) - total_energy(system_, model.state)) / energy_scale(model);
    }
    return report_;
  }

 private:
  void next_frame() {
    const std::int64_t frame = files_->frames();
    const double end = times_[static_cast<std::size_t>(frame)];
    if (!integrator_) {
      integrator_.emplace(make_integrator(request_.method.integrator, system_, request_.method.options));
      prepared_ = false;
    }
    State state = report_.state;
    report_.status = request_.method.tolerance > 0.0 ? adaptive_to(end, state) : fixed_to(end, state);
    prepared_ = true;
    report_.state = state;
    if (!report_.status.ok()) return;
    write(frame);
    if (frame % every_ == 0 || end == times_.back()) save();
    progress_.advance(request_.scene.model.name);
  }

  Status fixed_to(double end, State& state) {
    const double dt = equal_step(end - state.t, request_.method.dt);
    report_.dt = std::isnan(report_.dt) ? dt : std::max(report_.dt, dt);
    const double left = request_.method.max_seconds - report_.seconds;
    if (request_.method.max_seconds > 0.0 && !(left > 0.0)) return out_of_time(state);
    const RunResult result =
        simulate(system_, *integrator_, state, history_,
                 {.dt = dt,
                  .end_time = end,
                  .max_seconds = request_.method.max_seconds > 0.0 ? left : 0.0,
                  .observer = [](const State&, const History&) { return !interrupt_requested(); },
                  .check = &check_,
                  .prepare = !prepared_});
    report_.steps += result.steps;
    report_.seconds += result.seconds;
    return result.status;
  }

  // The bound of methods that do not extrapolate is per unit of the whole run.
  Status adaptive_to(double end, State& state) {
    if (request_.method.max_seconds > 0.0 && report_.seconds > request_.method.max_seconds)
      return out_of_time(state);
    const bool extrapolate =
        !system_.has_hard_rows && system_.bodies.empty() && !info(*integrator_).symmetric;
    const double share = extrapolate ? 1.0 : (end - state.t) / times_.back();
    const AdaptiveResult result =
        simulate_adaptive(system_, *integrator_, state, history_,
                          {.tolerance = request_.method.tolerance * share,
                           .first_dt = std::min(request_.method.dt, end - state.t),
                           .end_time = end,
                           .extrapolate = extrapolate,
                           .observer = [](const State&, double, double) { return !interrupt_requested(); }});
    report_.steps += result.accepted;
    report_.seconds += result.seconds;
    report_.dt = std::isnan(report_.dt) ? result.largest_dt : std::max(report_.dt, result.largest_dt);
    return result.status;
  }

  Status out_of_time(const State& state) const {
    return Status::failure(StatusCode::kLimitReached,
                           "wall-clock budget used up at t = " + feder::to_text(state.t) + " s");
  }

  void write(std::int64_t frame) {
    const Stopwatch watch;
    files_->add(frame, report_.state, history_);
    report_.seconds_output += watch.seconds();
  }

  void save() {
    const Stopwatch watch;
    write_checkpoint(request_.folder / kCheckpointFile, {request_.scene_hash, files_->frames(), report_.steps,
                                                         report_.state, history_, files_->positions()});
    report_.seconds_output += watch.seconds();
    collect_times();
  }

  // The linear solver's phase times, before the integrator goes.
  void collect_times() {
    if (!integrator_) return;
    if (const LinearSolver* solver = linear_solver(*integrator_)) {
      const PhaseTimes& t = solver->times();
      report_.route = solver->route_name();
      report_.seconds_assemble += t.assemble;
      report_.seconds_factor += t.factor;
      report_.seconds_solve += t.solve + t.transfer + t.residual + t.refine;
    } else {
      report_.route = "none";
    }
    integrator_.reset();
  }

  void close_quietly() {
    try {
      files_->finish();
    } catch (const IoError&) {  // the first failure is the one to tell
    }
  }

  const RunRequest& request_;
  const System& system_;
  std::vector<double> times_;
  DivergenceCheck check_;
  Progress& progress_;
  std::int64_t every_ = 1;
  std::optional<FrameFiles> files_;
  std::optional<Integrator> integrator_;
  bool prepared_ = false;
  History history_;
  RunReport report_;
};

}  // namespace

RunReport run_scene(const RunRequest& request, Progress& progress) {
  return Run(request, progress).go();
}

}  // namespace feder::experiments
