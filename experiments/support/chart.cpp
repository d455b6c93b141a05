#include "experiments/support/chart.h"

#include <algorithm>

namespace feder::experiments {

std::vector<Series> series_by(const Table& table, std::string_view group, std::string_view x,
                              std::string_view y, const std::function<bool(std::size_t row)>& keep) {
  const bool has_status = table.has("status");
  const bool has_floor = y == "error" && table.has("reference_error");
  std::vector<Series> all;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (keep && !keep(row)) continue;
    const std::string label = table.at(row, group).text();
    auto series = std::find_if(all.begin(), all.end(), [&](const Series& s) { return s.label == label; });
    if (series == all.end()) series = all.insert(all.end(), Series{.label = label});
    if (has_status && table.at(row, "status").text() != "ok") {
      series->failed_x.push_back(table.at(row, x).number());
      continue;
    }
    series->add(table.at(row, x).number(), table.at(row, y).number());
    if (has_floor) series->floor.push_back(table.at(row, "reference_error").number());
  }
  return all;
}

}  // namespace feder::experiments
