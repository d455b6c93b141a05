#pragma once

#include <filesystem>
#include <vector>

#include "experiments/support/sweep_table.h"

namespace feder::experiments {

/// A plan with its rows.
struct SweepResult {
  SweepPlan plan;
  Table table;
};

/// Joins the shards of one sweep: every case of the plan exactly once, in the order of the plan. Throws
/// InputError if the folders hold different sweeps, IoError if cases are missing, interrupted or there twice;
/// it names them and the commands that run what is missing.
SweepResult merge_shards(const std::vector<std::filesystem::path>& folders);

}  // namespace feder::experiments
