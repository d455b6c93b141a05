#pragma once

#include <map>
#include <string>
#include <vector>

#include "experiments/support/sweep_plan.h"
#include "experiments/support/table.h"

namespace feder::experiments {

/// The columns every sweep has: "case" before those of the keys, the results after them.
const std::vector<std::string>& result_columns();

/// How a case ended, and what it found.
struct CaseOutcome {
  std::string status = {};  ///< a word of the contract, "bad_input" or "internal_error"
  std::string reason = {};
  double seconds = 0;                        ///< wall time of the child process [s]
  double limit = 0;                          ///< the time limit that ended it [s], 0 if none did
  std::map<std::string, Cell> results = {};  ///< column -> value, without status and reason
};

/// The table without rows.
Table sweep_table(const SweepPlan& plan);
/// Appends the row of one case.
void add_row(Table& table, const SweepPlan& plan, const SweepCase& one, const CaseOutcome& outcome);

/// "12 of 20 cases have rows: 10 ok, 2 diverged".
std::string count_by_status(const Table& table, std::size_t cases);

}  // namespace feder::experiments
