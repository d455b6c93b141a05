#pragma once

#include <string>

namespace CLI {
class App;
}

namespace feder::experiments {

/// What every program says under --help about its exit codes.
inline constexpr const char* kExitCodes =
    "Exit codes: 0 done, 1 internal error, 2 bad input, 3 numerical failure, 4 input/output,\n"
    "5 out of memory or limit, 130 interrupted.";

inline constexpr int kMostThreads = 1024;

/// Adds --version and reads the command line; false after --help and --version, which it answers itself.
/// Throws InputError.
bool parse_command_line(CLI::App& app, int argc, char** argv);

}  // namespace feder::experiments
