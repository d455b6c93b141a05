#include "experiments/support/sweep_run.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <list>
#include <optional>

#include "experiments/support/hash.h"
#include "experiments/support/interrupt.h"
#include "experiments/support/progress.h"
#include "experiments/support/sweep_child.h"
#include "experiments/support/sweep_outcome.h"
#include "experiments/support/sweep_table.h"

namespace feder::experiments {
namespace {

constexpr double kLook = 0.05;      ///< seconds between two looks at clocks and signals
constexpr double kTablePeriod = 1;  ///< at least so many seconds between two writes of the table,
constexpr double kTableShare = 20;  ///< and so many times as long as a write takes

/// One sweep at a time in a folder. The lock goes with the process.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& folder)
      : id_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    if (id_ >= 0 && ::flock(id_, LOCK_EX | LOCK_NB) == 0) return;
    if (id_ >= 0) ::close(id_);
    throw IoError("another sweep is running in '" + folder.string() + "'");
  }
  ~FolderLock() { ::close(id_); }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int id_;
};

std::filesystem::path folder_of(const SweepRun& run, const SweepCase& one) {
  return run.out / "cases" / one.id;
}

/// The outcome a case has from an earlier run, if it can stay.
std::optional<CaseOutcome> stored(const SweepPlan& plan, const SweepRun& run, const SweepCase& one) {
  std::optional<CaseOutcome> outcome = read_outcome(folder_of(run, one), fingerprint(plan, one));
  if (outcome && !is_final(*outcome, run.limit)) outcome.reset();
  return outcome;
}

/// Carries out one plan: what is done, what runs, what is to come.
class Sweep {
 public:
  Sweep(const SweepPlan& plan, const SweepRun& run)
      : plan_(plan), run_(run), outcomes_(plan.cases.size()), progress_(run.quiet) {
    for (std::size_t i = 0; i < plan.cases.size(); ++i) {
      if (!plan.shard.owns(i)) continue;
      outcomes_[i] = stored(plan, run, plan.cases[i]);
      if (!outcomes_[i]) to_do_.push_back(i);
    }
    progress_.start(static_cast<long>(to_do_.size()));
  }

  std::size_t to_do() const { return to_do_.size(); }

  Ending carry_out() {
    while (next_ < to_do_.size() || !running_.empty()) {
      const bool stopping = interrupt_requested();
      if (stopping && running_.empty()) break;
      if (stopping) stop_all();
      while (!stopping && running_.size() < static_cast<std::size_t>(run_.jobs) && next_ < to_do_.size())
        start(to_do_[next_++]);
      waiter_.wait(kLook);
      collect(stopping);
      save_now_and_then();
    }
    const bool missing = std::any_of(to_do_.begin(), to_do_.end(), [&](auto i) { return !outcomes_[i]; });
    if (missing)
      return ending_of(
          Status::failure(StatusCode::kInterrupted, "stopped by a signal; the table holds the cases so far"));
    // one bad value is a row, but if nothing could be run the command was wrong
    const bool refused = std::all_of(outcomes_.begin(), outcomes_.end(),
                                     [](const auto& o) { return o && o->status == "bad_input"; });
    if (refused && !outcomes_.empty())
      return {2, "bad_input", "every case was refused, the first: " + outcomes_.front()->reason};
    return {};
  }

  void save(const Ending& ending) {
    const Stopwatch watch;
    write_sweep(plan_, table(), run_.out, ending, watch_.seconds());
    save_seconds_ = watch.seconds();
    since_save_.restart();
  }

  Table table() const {
    Table rows = sweep_table(plan_);
    for (std::size_t i = 0; i < outcomes_.size(); ++i) {
      if (outcomes_[i]) add_row(rows, plan_, plan_.cases[i], *outcomes_[i]);
    }
    return rows;
  }

  void clear_progress() { progress_.clear(); }

 private:
  struct Running {
    Running(std::size_t position_, const std::vector<std::string>& command,
            const std::filesystem::path& stderr_file, double limit)
        : position(position_), child(command, stderr_file, limit) {}

    std::size_t position;
    Child child;
  };

  void start(std::size_t position) {
    if (text_hash(read_file(plan_.scene)) != plan_.scene_hash)
      throw InputError(fmt::format("{}: the scene changed while its sweep ran", plan_.scene));
    const SweepCase& one = plan_.cases[position];
    const std::filesystem::path folder = folder_of(run_, one);
    // Nothing of an earlier attempt may be taken for this one's result.
    std::error_code error;
    std::filesystem::remove_all(folder, error);
    if (error) throw IoError("cannot remove '" + folder.string() + "': " + error.message());
    create_folder(folder);
    running_.emplace_back(position, command_of(plan_, one, run_.simulate, folder), folder / "stderr.txt",
                          run_.limit);
  }

  void stop_all() {
    for (Running& one : running_) one.child.stop();
  }

  void collect(bool stopping) {
    for (auto one = running_.begin(); one != running_.end();) {
      const std::optional<ChildEnd> end = one->child.poll();
      if (end) finish(one->position, *end, stopping);
      one = end ? running_.erase(one) : std::next(one);
    }
  }

  void finish(std::size_t position, const ChildEnd& end, bool stopping) {
    const bool cut_short = stopping && end.stopped && (end.signal != 0 || end.exit_code != 0);
    if (cut_short) return;
    const SweepCase& one = plan_.cases[position];
    const std::filesystem::path folder = folder_of(run_, one);
    outcomes_[position] = judge(end, folder, run_.limit);
    create_folder(folder);
    write_outcome(folder, *outcomes_[position], fingerprint(plan_, one));
    progress_.advance(describe(plan_, one));
  }

  void save_now_and_then() {
    if (since_save_.seconds() > std::max(kTablePeriod, kTableShare * save_seconds_))
      save({130, "interrupted", "still running, or killed"});
  }

  const SweepPlan& plan_;
  const SweepRun& run_;
  std::vector<std::optional<CaseOutcome>> outcomes_;
  std::vector<std::size_t> to_do_;
  std::size_t next_ = 0;
  ChildWaiter waiter_;
  std::list<Running> running_;
  Progress progress_;
  Stopwatch watch_;
  Stopwatch since_save_;
  double save_seconds_ = 0;
};

/// What write_file() leaves when the program is killed under it. Only for the holder of the lock.
void remove_leftovers(const std::filesystem::path& out) {
  for (const auto& entry : std::filesystem::directory_iterator(out)) {
    const std::string name = entry.path().filename().string();
    for (const char* file : {"plan.json.tmp", "sweep.csv.tmp", "manifest.json.tmp"}) {
      if (name.starts_with(file)) std::filesystem::remove(entry.path());
    }
  }
}

}  // namespace

Ending run_sweep(const SweepPlan& plan, const SweepRun& run) {
  create_folder(run.out);
  const FolderLock lock(run.out);
  remove_leftovers(run.out);
  write_plan(plan, run.out);
  Sweep sweep(plan, run);
  const auto say = [&](const std::string& text) {
    sweep.clear_progress();
    if (!run.quiet) std::fputs((text + "\n").c_str(), stdout), std::fflush(stdout);
  };
  const std::size_t size = shard_size(plan);
  say(fmt::format("{} cases, {} of them done before", size, size - sweep.to_do()));
  sweep.save({130, "interrupted", "still running, or killed"});
  Ending ending = guarded([&] { return sweep.carry_out(); });
  const Ending written = guarded([&] { return sweep.save(ending), Ending{}; });
  if (ending.code == 0) ending = written;
  say(count_by_status(sweep.table(), size));
  say(fmt::format("Results are in {}", run.out.string()));
  return ending;
}

std::string describe(const SweepPlan& plan, const SweepRun& run) {
  const std::size_t size = shard_size(plan);
  std::string text = fmt::format("{} cases", plan.cases.size());
  if (plan.shard.count > 1)
    text += fmt::format(", {} of them in shard {}/{}", size, plan.shard.index, plan.shard.count);
  text += "\n";
  std::vector<double> seconds;
  for (std::size_t i = 0; i < plan.cases.size(); ++i) {
    if (!plan.shard.owns(i)) continue;
    const std::optional<CaseOutcome> done = stored(plan, run, plan.cases[i]);
    if (done) seconds.push_back(done->seconds);
    text +=
        fmt::format("{}  {}{}\n", plan.cases[i].id, describe(plan, plan.cases[i]), done ? "  (done)" : "");
  }
  if (seconds.empty())
    return text + "No case has been run in this folder yet, so there is no estimate of the time.\n";
  const double each = median(seconds);
  return text + fmt::format("{} to do, {:.3g} s each, {} at a time: about {:.3g} s\n", size - seconds.size(),
                            each, run.jobs, each * static_cast<double>(size - seconds.size()) / run.jobs);
}

}  // namespace feder::experiments
