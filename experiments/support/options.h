#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "experiments/support/experiment.h"

namespace feder::experiments {

/// The command line that every experiment shares.
struct Options {
  bool list = false;
  bool dry_run = false;
  bool quiet = false;
  std::string preset = "quick";
  std::vector<std::string> changes;  ///< "key=value"
  std::uint64_t seed = 1;
  std::string out;  ///< "results/<name>" unless given
  int threads = 1;
};

/// Reads the command line; empty after --help and --version, which it answers itself. Throws InputError.
std::optional<Options> parse_options(const ExperimentInfo& info, int argc, char** argv);

/// What --dry-run prints: every resolved option, every setting with its meaning, the cases.
std::string describe(const ExperimentInfo& info, const Options& options, const Settings& settings);

}  // namespace feder::experiments
