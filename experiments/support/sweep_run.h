#pragma once

#include <filesystem>
#include <string>

#include "experiments/support/program.h"
#include "experiments/support/sweep_table.h"

namespace feder::experiments {

/// How a plan is carried out: nothing here changes a result.
struct SweepRun {
  std::string simulate;  ///< the program
  std::filesystem::path out;
  int jobs = 1;
  double limit = 3600;  ///< wall time of one case [s]
  bool quiet = false;
};

/// Runs the cases of the plan's shard that are not in `out` yet and writes plan.json, sweep.csv and
/// manifest.json there. Failed cases are rows; only an interrupt, trouble with files and a changed scene end
/// it early, with the rows so far written. Throws IoError.
Ending run_sweep(const SweepPlan& plan, const SweepRun& run);

/// What --dry-run prints: the number of cases, each one, and once cases have been run the expected time.
std::string describe(const SweepPlan& plan, const SweepRun& run);

/// Writes plan.json, after removing the table and the manifest of any other plan: a table without its own
/// plan never exists. Throws IoError.
void write_plan(const SweepPlan& plan, const std::filesystem::path& out);

/// Writes sweep.csv and manifest.json for the rows in `table`.
void write_sweep(const SweepPlan& plan, const Table& table, const std::filesystem::path& out,
                 const Ending& ending, double wall_seconds);

}  // namespace feder::experiments
