#include "experiments/support/interrupt.h"

#include <csignal>

namespace feder::experiments {
namespace {

volatile std::sig_atomic_t requested = 0;

extern "C" void feder_note_interrupt(int) {
  requested = 1;
}

}  // namespace

void watch_interrupts() {
  struct sigaction action = {};
  action.sa_handler = feder_note_interrupt;
  // One shot: the second signal finds the default action again.
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

bool interrupt_requested() {
  return requested != 0;
}

}  // namespace feder::experiments
