#pragma once

#include <functional>
#include <string>
#include <vector>

#include "experiments/support/context.h"

namespace feder::experiments {

/// What an experiment is, apart from its code.
struct ExperimentInfo {
  std::string name = {};          ///< that of its source file
  std::string question = {};      ///< one sentence
  std::string not_modelled = {};  ///< one sentence: what the answer leaves out
  std::vector<Setting> settings = {};
  std::vector<std::string> columns = {};  ///< of the results table
  std::vector<std::string> cases = {};    ///< printed by --list
};

/// The whole main(): command line, environment, body, files, manifest, exit code.
///
///   --help --list --dry-run --version --preset quick|full --set key=value --seed N --out DIR --threads N
///   --quiet
///
/// Exit codes: 0 done, 1 internal error, 2 bad input, 3 numerical failure, 4 input/output, 5 memory or limit,
/// 130 interrupted. Whatever ends the body, the rows added so far are written.
int run_experiment(const ExperimentInfo& info, int argc, char** argv,
                   const std::function<void(Context&)>& body);

}  // namespace feder::experiments
