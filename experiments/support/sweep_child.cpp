#include "experiments/support/sweep_child.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <ctime>
#include <string_view>
#include <system_error>
#include <utility>

#include "experiments/support/files.h"

namespace feder::experiments {
namespace {

constexpr double kGrace = 2;  ///< seconds between SIGTERM and SIGKILL

/// Between fork and exec: nothing here may allocate or lock.
[[noreturn]] void become(char* const* arguments, pid_t parent, int silence, int errors) {
  ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(127);
  ::dup2(silence, STDIN_FILENO);
  ::dup2(silence, STDOUT_FILENO);
  ::dup2(errors, STDERR_FILENO);
  ::signal(SIGPIPE, SIG_DFL);
  ::signal(SIGINT, SIG_DFL);
  ::signal(SIGTERM, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  ::execv(arguments[0], arguments);
  constexpr std::string_view kMessage = "the program cannot be run\n";
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, kMessage.data(), kMessage.size());
  ::_exit(127);
}

sigset_t child_signal() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGCHLD);
  return set;
}

}  // namespace

Child::Child(const std::vector<std::string>& command, const std::filesystem::path& stderr_file, double limit)
    : limit_(limit) {
  std::vector<std::string> words = command;
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const int silence = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  const int errors = ::open(stderr_file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  const pid_t parent = ::getpid();
  int error = errno;
  if (silence >= 0 && errors >= 0) {
    id_ = ::fork();
    error = errno;
  }
  if (id_ == 0) become(arguments.data(), parent, silence, errors);
  if (silence >= 0) ::close(silence);
  if (errors >= 0) ::close(errors);
  if (id_ < 0) throw IoError("cannot start '" + command[0] + "': " + std::generic_category().message(error));
  // Both sides set the group, so that it exists whoever comes first.
  ::setpgid(id_, id_);
}

Child::~Child() {
  if (id_ < 0) return;
  ::kill(-id_, SIGKILL);
  while (::waitpid(id_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

void Child::stop() {
  if (id_ < 0 || since_stop_) return;
  since_stop_.emplace();
  ::kill(-id_, SIGTERM);
}

std::optional<ChildEnd> Child::poll() {
  siginfo_t info = {};
  // The process stays a zombie until its group is gone: so its number cannot belong to anybody else.
  ::waitid(P_PID, static_cast<id_t>(id_), &info, WEXITED | WNOHANG | WNOWAIT);
  if (info.si_pid == 0) {
    if (watch_.seconds() > limit_) stop();
    if (since_stop_ && since_stop_->seconds() > kGrace) ::kill(-id_, SIGKILL);
    return std::nullopt;
  }
  ::kill(-id_, SIGKILL);
  ::waitpid(std::exchange(id_, -1), nullptr, 0);
  const bool exited = info.si_code == CLD_EXITED;
  return ChildEnd{exited ? info.si_status : 0, exited ? 0 : info.si_status, since_stop_.has_value(),
                  watch_.seconds()};
}

ChildWaiter::ChildWaiter() {
  // Whoever started this program may have left it ignored, and then nobody's end is ever reported.
  ::signal(SIGCHLD, SIG_DFL);
  const sigset_t set = child_signal();
  ::sigprocmask(SIG_BLOCK, &set, nullptr);
}

ChildWaiter::~ChildWaiter() {
  const sigset_t set = child_signal();
  ::sigprocmask(SIG_UNBLOCK, &set, nullptr);
}

void ChildWaiter::wait(double seconds) const {
  const sigset_t set = child_signal();
  const timespec time = {
      static_cast<time_t>(seconds),
      static_cast<long>(1e9 * (seconds - static_cast<double>(static_cast<time_t>(seconds))))};
  ::sigtimedwait(&set, nullptr, &time);
}

}  // namespace feder::experiments
