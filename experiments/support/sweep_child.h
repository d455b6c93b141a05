#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "experiments/support/timing.h"

namespace feder::experiments {

/// How a child process ended.
struct ChildEnd {
  int exit_code = 0;     ///< meaningless if a signal ended it
  int signal = 0;        ///< 0 if it ended by itself
  bool stopped = false;  ///< because it was told to: by stop() or by its time limit
  double seconds = 0;
};

/// A child process in a process group of its own. It dies with this program, however this program dies.
class Child {
 public:
  /// Starts the command with nothing on stdin and stdout, and stderr in a file. `limit` is its wall time [s].
  /// Throws IoError; a program that cannot be run ends with code 127.
  Child(const std::vector<std::string>& command, const std::filesystem::path& stderr_file, double limit);
  /// Kills what still runs.
  ~Child();
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// SIGTERM to its whole group, SIGKILL two seconds later.
  void stop();
  /// The end, once it has come. Enforces the limits; to be called every now and then until it answers.
  std::optional<ChildEnd> poll();

 private:
  pid_t id_ = -1;
  double limit_ = 0;
  std::optional<Stopwatch> since_stop_;
  Stopwatch watch_;
};

/// While it lives, wait() sleeps until a child ends.
class ChildWaiter {
 public:
  ChildWaiter();
  ~ChildWaiter();
  ChildWaiter(const ChildWaiter&) = delete;
  ChildWaiter& operator=(const ChildWaiter&) = delete;

  /// Returns when a child has ended, a signal has come or `seconds` have passed.
  void wait(double seconds) const;
};

}  // namespace feder::experiments
