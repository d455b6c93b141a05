#include "experiments/support/trajectory_csv.h"

#include "experiments/support/table.h"
#include "experiments/support/trajectory_columns.h"

namespace feder::experiments {

TrajectoryCsv::TrajectoryCsv(const Scene& scene) {
  for (const std::string& column : trajectory_columns(scene)) header_ += csv_field(column) + ",";
  header_.back() = '\n';
}

void TrajectoryCsv::add(const Frame& frame, TextBuffer& text) {
  text.add_number(frame.state.t);
  text.add_cells(frame.state.q.data(), frame.state.q.size());
  text.add_cells(frame.state.v.data(), frame.state.v.size());
  text.add("\n");
}

}  // namespace feder::experiments
