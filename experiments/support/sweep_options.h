#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "experiments/support/sweep_run.h"

namespace feder::experiments {

/// What the command line of `sweep` asks for.
struct SweepOptions {
  SweepPlan plan;
  SweepRun run;
  bool dry_run = false;
};

/// What `sweep merge` asks for.
struct MergeOptions {
  std::vector<std::filesystem::path> folders;
  std::filesystem::path out;
  bool quiet = false;
};

/// Empty after --help and --version. They read the scene and the list, and throw InputError for everything
/// that can be found wrong before the first case.
std::optional<SweepOptions> parse_sweep(int argc, char** argv);
std::optional<MergeOptions> parse_merge(int argc, char** argv);

}  // namespace feder::experiments
