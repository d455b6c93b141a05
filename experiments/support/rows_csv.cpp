#include "experiments/support/rows_csv.h"

#include <fmt/format.h>

#include "experiments/support/table.h"

namespace feder::experiments {

RowsCsv::RowsCsv(const Scene& scene) : scene_(&scene) {
  for (const SceneRow& row : scene.rows)
    names_.push_back(fmt::format(",{},{},", csv_field(row.name), csv_field(row.type)));
}

void RowsCsv::add(const Frame& frame, TextBuffer& text) {
  const VectorXd& lambda = frame.history.lambda;
  time_.clear();
  time_.add_number(frame.state.t);
  for (std::size_t i = 0; i < names_.size(); ++i) {
    const SceneRow& row = scene_->rows[i];
    for (int component = 0; component < row.rows; ++component) {
      const int k = row.first_row + component;
      text.add(time_.text());
      text.add(names_[i]);
      text.add_number(component);
      text.add_cells(frame.phi.data() + k, 1);
      if (lambda.size() == 0)
        text.add(",");
      else
        text.add_cells(lambda.data() + k, 1);
      text.add("\n");
    }
  }
}

}  // namespace feder::experiments
