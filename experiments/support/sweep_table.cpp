#include "experiments/support/sweep_table.h"

#include <fmt/format.h>

namespace feder::experiments {

const std::vector<std::string>& result_columns() {
  static const std::vector<std::string> columns = {"scene",
                                                   "integrator",
                                                   "route",
                                                   "dt",
                                                   "status",
                                                   "reason",
                                                   "steps",
                                                   "error",
                                                   "reference_error",
                                                   "energy_drift",
                                                   "scene_length",
                                                   "seconds",
                                                   "seconds_assemble",
                                                   "seconds_factor",
                                                   "seconds_solve"};
  return columns;
}

Table sweep_table(const SweepPlan& plan) {
  std::vector<std::string> columns = {"case"};
  columns.insert(columns.end(), plan.keys.begin(), plan.keys.end());
  columns.insert(columns.end(), result_columns().begin(), result_columns().end());
  return Table(columns);
}

void add_row(Table& table, const SweepPlan& plan, const SweepCase& one, const CaseOutcome& outcome) {
  Table::Row row = {{"case", one.id}, {"status", outcome.status}, {"reason", outcome.reason}};
  for (std::size_t i = 0; i < plan.keys.size(); ++i) row.emplace_back(plan.keys[i], one.values[i]);
  for (const auto& [column, value] : outcome.results) row.emplace_back(column, value);
  table.add(row);
}

std::string count_by_status(const Table& table, std::size_t cases) {
  std::map<std::string, int> counts;
  for (std::size_t row = 0; row < table.rows(); ++row) ++counts[table.at(row, "status").text()];
  std::string text = fmt::format("{} of {} cases have rows", table.rows(), cases);
  const char* separator = ": ";
  for (const auto& [status, count] : counts) {
    text += fmt::format("{}{} {}", separator, count, status);
    separator = ", ";
  }
  return text;
}

}  // namespace feder::experiments
