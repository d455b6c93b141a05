#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <system_error>

#include "experiments/support/chart.h"
#include "experiments/support/files.h"

namespace feder::experiments {
namespace {

/// What posix_spawn() has to do between fork and exec: enter the folder and send both outputs into a pipe.
class SpawnSetup {
 public:
  SpawnSetup(const std::filesystem::path& folder, int output) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_addchdir_np(&actions_, folder.c_str());
    posix_spawn_file_actions_adddup2(&actions_, output, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions_, output, STDERR_FILENO);
    // A group of its own: Ctrl-C in the terminal must not cut the picture short.
    posix_spawnattr_init(&attributes_);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETPGROUP);
  }
  ~SpawnSetup() {
    posix_spawn_file_actions_destroy(&actions_);
    posix_spawnattr_destroy(&attributes_);
  }
  SpawnSetup(const SpawnSetup&) = delete;
  SpawnSetup& operator=(const SpawnSetup&) = delete;

  int spawn(pid_t& child, char* const* arguments) {
    // in a bare locale gnuplot complains about every character that is not ASCII; the variable is for
    // children alone
    ::setenv("LC_ALL", "C.UTF-8", 1);
    return posix_spawnp(&child, arguments[0], &actions_, &attributes_, arguments, environ);
  }

 private:
  posix_spawn_file_actions_t actions_;
  posix_spawnattr_t attributes_;
};

std::string read_until_end(int id) {
  std::string text;
  std::array<char, 4096> part;
  for (;;) {
    const ssize_t count = ::read(id, part.data(), part.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return text;
    text.append(part.data(), static_cast<std::size_t>(count));
  }
}

/// Runs gnuplot in `folder`; throws IoError with gnuplot's own message unless it succeeds without a word.
void run_gnuplot(const std::filesystem::path& folder, const std::string& script, const std::string& svg) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw IoError("cannot create a pipe to gnuplot");
  std::array<std::string, 4> words = {"gnuplot", "-e", "output_file='" + svg + "'", script};
  std::array<char*, 5> arguments = {words[0].data(), words[1].data(), words[2].data(), words[3].data(),
                                    nullptr};
  pid_t child = 0;
  const int error = SpawnSetup(folder, ends[1]).spawn(child, arguments.data());
  ::close(ends[1]);
  const std::string output = error == 0 ? read_until_end(ends[0]) : "";
  ::close(ends[0]);
  if (error != 0) throw IoError("cannot run gnuplot: " + std::generic_category().message(error));
  int result = 0;
  while (::waitpid(child, &result, 0) < 0 && errno == EINTR) {
  }
  if (result != 0 || !output.empty())
    throw IoError(fmt::format("gnuplot failed on '{}': {}", script, output));
}

}  // namespace

void draw(const Chart& chart, const std::filesystem::path& folder) {
  write_file(folder / (chart.name + ".gp"), gnuplot_script(chart));
  const std::string temporary = fmt::format("{}.svg.tmp{}", chart.name, ::getpid());
  try {
    run_gnuplot(folder, chart.name + ".gp", temporary);
    commit_file(folder / temporary, folder / (chart.name + ".svg"));
  } catch (...) {
    ::unlink((folder / temporary).c_str());
    throw;
  }
}

}  // namespace feder::experiments
