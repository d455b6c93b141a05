#include "experiments/support/scene_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/check.h"
#include "engine/drive.h"
#include "engine/energy.h"
#include "experiments/support/files.h"
#include "experiments/support/interrupt.h"
#include "experiments/support/measure.h"
#include "experiments/support/timing.h"
#include "solvers/simulate.h"

namespace feder::experiments {
namespace {

constexpr double kStepsPerCheckpoint = 200.0;
constexpr double kSecondsPerCheckpoint = 1.0;

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

std::int64_t frames_per_checkpoint(const Output& output, double interval, double dt) {
  if (output.checkpoint_frames > 0) return output.checkpoint_frames;
  const double steps_per_frame = std::ceil(interval / dt);
  return static_cast<std::int64_t>(std::clamp(std::ceil(kStepsPerCheckpoint / steps_per_frame), 1.0, 1e9));
}

// What the run's own message cannot name: whose expression gave the bad number, and when.
void tell_where(const Scene& scene, const State& last, double dt, Status& status) {
  const System& s = scene.model.system;
  State next = last;
  next.t += dt;
  drive(s, next);
  VectorXd force;
  evaluate_external_forces(s, next, force);
  auto finite = [&](int node) { return force.segment<3>(3 * node).allFinite(); };
  for (const SceneNode& node : scene.nodes) {
    const bool moves =
        next.q.segment<3>(3 * node.node).allFinite() && next.v.segment<3>(3 * node.node).allFinite();
    if (status.code != StatusCode::kNonFinite || (moves && finite(node.node))) continue;
    status.reason +=
        fmt::format("; {} '{}' is not finite", moves ? "the force on" : "the motion of", node.name);
    break;
  }
  status.reason += fmt::format(" (step from t = {} s)", feder::to_text(last.t));
}

class Run {
 public:
  Run(const RunRequest& request, Progress& progress)
      : request_(request),
        method_(request.method),
        system_(request.scene.model.system),
        times_(frame_times(request.output, request.scene.model.end_time)),
        check_(system_, request.scene.model.state, times_.back(), method_.divergence),
        progress_(progress),
        every_(frames_per_checkpoint(request.output, times_[1] - times_[0], method_.dt)) {
    require_steps(method_, times_);
    report_.state = request.scene.model.state;
    report_.integrator = method_.integrator;
    for (std::size_t i = 1; i < times_.size() && method_.tolerance == 0.0; ++i) {
      const double dt = equal_step(times_[i - 1], times_[i], method_.dt);
      report_.dt = std::isnan(report_.dt) ? dt : std::max(report_.dt, dt);
    }
  }

  RunReport go() {
    if (request_.resume) read_start();
    try {
      open_files();
      progress_.start(static_cast<long>(count() - files_->frames()));
      do next_frame();
      while (files_->frames() < count() && report_.status.ok());
      files_->finish();
      if (last_) write_checkpoint(request_.folder / kCheckpointFile, *last_);
    } catch (const IoError& error) {
      report_.status = Status::failure(StatusCode::kIoError, error.what());
      close_quietly();
    }
    drop_integrator();
    report_.frames = files_ ? files_->frames() : 0;
    if (report_.status.ok()) {
      const Model& model = request_.scene.model;
      report_.energy_drift =
          (total_energy(system_, report_.state) - total_energy(system_, model.state)) / energy_scale(model);
    }
    return report_;
  }

 private:
  std::int64_t count() const { return static_cast<std::int64_t>(times_.size()); }

  void read_start() {
    const std::filesystem::path path = request_.folder / kCheckpointFile;
    if (!std::filesystem::exists(path))
      throw IoError("there is no '" + path.string() + "' to resume from: run without --resume");
    start_ = read_checkpoint(path);
    require_checkpoint_of(request_.scene, request_.scene_hash, *start_, path.string());
    report_.state = start_->state, history_ = start_->history, report_.steps = start_->step;
  }

  void open_files() {
    const FrameOptions options = frame_options(request_.output);
    if (start_) {
      files_.emplace(request_.scene, count(), request_.folder, options, *start_);
    } else {
      remove_file(request_.folder / kCheckpointFile);  // it belongs to other files
      files_.emplace(request_.scene, count(), request_.folder, options);
      write(0);
      save(true);
    }
  }

  void next_frame() {
    const std::int64_t frame = files_->frames();
    if (!integrator_) {
      integrator_.emplace(make_integrator(method_.integrator, system_, method_.options));
      prepared_ = false;
    }
    if (frame == count()) {  // nothing is left to do but to find out on which route
      report_.status = std::visit([](auto& i) { return i.prepare(); }, *integrator_);
      return;
    }
    const double end = times_[static_cast<std::size_t>(frame)];
    State state = report_.state;
    report_.status = method_.tolerance > 0.0 ? adaptive_to(end, state) : fixed_to(end, state);
    prepared_ = true;
    report_.state = state;
    if (!report_.status.ok()) return;
    write(frame);
    const bool last = files_->frames() == count();
    if (frame % every_ == 0 || last) save(last || request_.output.checkpoint_frames > 0);
    progress_.advance(request_.scene.model.name);
    if (request_.observer && !request_.observer(files_->frames()) && !last)
      report_.status = Status::failure(StatusCode::kInterrupted, "stopped by the observer");
  }

  Status fixed_to(double end, State& state) {
    if (out_of_time()) return time_is_up(state);
    const double dt = equal_step(state.t, end, method_.dt);
    const RunResult result =
        simulate(system_, *integrator_, state, history_,
                 {.dt = dt,
                  .end_time = end,
                  .max_seconds = method_.max_seconds > 0.0 ? method_.max_seconds - report_.seconds : 0.0,
                  .observer = [](const State&, const History&) { return !interrupt_requested(); },
                  .check = &check_,
                  .prepare = !prepared_});
    report_.steps += result.steps;
    report_.seconds += result.seconds;
    Status status = result.status;
    if (interrupt_requested() && !status.ok()) return stopped();
    if (!status.ok() && exit_code(status.code) == 3) tell_where(request_.scene, state, dt, status);
    return status;
  }

  // The bound of methods that do not extrapolate is per unit of the whole run.
  Status adaptive_to(double end, State& state) {
    if (out_of_time()) return time_is_up(state);
    const bool extrapolate =
        !system_.has_hard_rows && system_.bodies.empty() && !info(*integrator_).symmetric;
    const double share = extrapolate ? 1.0 : (end - state.t) / times_.back();
    const double before = report_.seconds;
    const Stopwatch watch;
    bool late = false;
    const AdaptiveResult result = simulate_adaptive(system_, *integrator_, state, history_,
                                                    {.tolerance = method_.tolerance * share,
                                                     .first_dt = std::min(method_.dt, end - state.t),
                                                     .end_time = end,
                                                     .extrapolate = extrapolate,
                                                     .observer = [&](const State&, double, double) {
                                                       report_.seconds = before + watch.seconds();
                                                       late = out_of_time();
                                                       return !interrupt_requested() && !late;
                                                     }});
    report_.steps += result.accepted;
    report_.seconds = before + result.seconds;
    report_.dt = std::isnan(report_.dt) ? result.largest_dt : std::max(report_.dt, result.largest_dt);
    if (!result.status.ok() && interrupt_requested()) return stopped();
    if (!result.status.ok()) return late ? time_is_up(state) : result.status;
    return check_(state);
  }

  bool out_of_time() const { return method_.max_seconds > 0.0 && report_.seconds >= method_.max_seconds; }

  static Status stopped() {
    return Status::failure(StatusCode::kInterrupted,
                           "stopped by a signal; the same command with --resume goes on");
  }

  static Status time_is_up(const State& state) {
    return Status::failure(StatusCode::kLimitReached,
                           "wall-clock budget used up at t = " + feder::to_text(state.t) + " s");
  }

  void write(std::int64_t frame) {
    const Stopwatch watch;
    files_->add(frame, report_.state, shown());
    report_.seconds_output += watch.seconds();
  }

  // The history with what the rows pull with, where somebody asks and the method itself does not say.
  const History& shown() {
    const FrameOptions options = frame_options(request_.output);
    if (history_.lambda.size() > 0 || !(options.rows || options.vtu)) return history_;
    if (!forces_) {
      forces_.emplace(system_, IntegratorOptions{});
      if (!forces_->prepare().ok()) return history_;
    }
    shown_ = history_;
    if (!forces_->row_forces(report_.state, shown_.lambda).ok()) shown_.lambda.resize(0);
    return shown_;
  }

  // The integrator goes whether or not the disk gets the checkpoint.
  void save(bool now) {
    const Stopwatch watch;
    last_ = {request_.scene_hash, files_->frames(), report_.steps,
             report_.state,       history_,         files_->lengths()};
    if (now || since_checkpoint_.seconds() >= kSecondsPerCheckpoint) {
      last_->files = files_->positions();
      write_checkpoint(request_.folder / kCheckpointFile, *last_);
      last_.reset();
      since_checkpoint_.restart();
    }
    report_.seconds_output += watch.seconds();
    drop_integrator();
  }

  // Keeps the linear solver's phase times.
  void drop_integrator() {
    forces_.reset();
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

  // The first failure is the one to tell.
  void close_quietly() {
    try {
      if (files_) files_->finish();
    } catch (const IoError&) {
    }
  }

  const RunRequest& request_;
  const Method& method_;
  const System& system_;
  std::vector<double> times_;
  DivergenceCheck check_;
  Progress& progress_;
  std::int64_t every_;
  std::optional<Checkpoint> start_;  ///< what the run goes on from
  std::optional<Checkpoint> last_;   ///< that is not on disk
  Stopwatch since_checkpoint_;
  std::optional<FrameFiles> files_;
  std::optional<Integrator> integrator_;
  bool prepared_ = false;
  std::optional<Rk4> forces_;  ///< tells row forces, not used to step
  History history_, shown_;
  RunReport report_;
};

}  // namespace

void require_steps(const Method& method, const std::vector<double>& times) {
  for (std::size_t i = 1; i < times.size(); ++i)
    (void)step_count(times[i - 1], times[i], equal_step(times[i - 1], times[i], method.dt));
}

RunReport run_scene(const RunRequest& request, Progress& progress) {
  return Run(request, progress).go();
}

}  // namespace feder::experiments
