#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace feder::experiments {

/// What the command line of `simulate` asks for.
struct SimulateOptions {
  std::filesystem::path scene;
  std::vector<std::string> changes;  ///< "key=value" of the scene, those of --integrator, --route, --dt last
  std::string preset = "full";
  std::filesystem::path out;  ///< "results/scenes/<stem of the scene file>" unless given
  std::uint64_t seed = 1;
  int threads = 1;
  bool reference = false, allow_outside = false, quiet = false;
  bool validate = false, explain = false, keys = false, list = false, dry_run = false, resume = false;
  std::filesystem::path rerun;  ///< manifest to do again, empty: none
};

/// Empty after --help and --version, which it answers. Throws InputError.
std::optional<SimulateOptions> parse_simulate(int argc, char** argv);

}  // namespace feder::experiments
