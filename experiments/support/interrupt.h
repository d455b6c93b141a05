#pragma once

namespace feder::experiments {

/// From now on the first SIGINT or SIGTERM only sets the flag; a second one ends the program at once. A
/// closed pipe on stdout no longer kills the program before its files are written.
void watch_interrupts();

/// True once a signal has arrived.
bool interrupt_requested();

}  // namespace feder::experiments
