#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/support/table.h"

namespace feder::experiments {

/// One curve. The same label gets the same colour, marker and dash in every panel of a chart; to look alike
/// in all charts it needs a `look`, for instance the place of the method in its list.
struct Series {
  std::string label = {};
  std::vector<double> x = {};
  std::vector<double> y = {};
  std::vector<double> floor = {};     ///< empty, or the judge's own error per point: hollow where y < floor
  std::vector<double> failed_x = {};  ///< failed runs: crosses along the top edge
  std::optional<std::size_t> look = {};  ///< fixed place in the palette: the same method alike in every chart
  bool markers = true;
  bool line = true;
  double marker_size = 0.9;  ///< less for clouds of points; the legend shows it full
  bool theory = false;       ///< a prediction: thick dashed grey line without markers

  void add(double x_value, double y_value) { x.push_back(x_value), y.push_back(y_value); }
};

/// Label with unit ("time step dt [s]"). Limits are taken from the data where absent.
struct Axis {
  std::string label = {};
  bool log = false;
  std::optional<double> min = {};
  std::optional<double> max = {};
};

/// A straight grey reference line y ~ x^order on log-log axes. Without anchor (its right end) it lies under
/// the series whose own slope is nearest.
struct Slope {
  double order = 1;
  std::string label = {};  ///< "slope <order>" if empty
  std::optional<double> x = {};
  std::optional<double> y = {};
};

/// A vertical or horizontal grey line with a label, for instance a predicted stability limit.
struct Mark {
  double at = 0;
  std::string label = {};
  bool vertical = true;
};

struct Panel {
  std::string title = {};
  Axis x = {};
  Axis y = {};
  std::vector<Series> series = {};
  std::vector<Slope> slopes = {};
  std::vector<Mark> marks = {};
  bool equal = false;  ///< linear axes of one scale, the shorter one widened: a circle is a circle
  std::optional<double> judge_error = {};  ///< horizontal dashed line: below it nothing can be told apart
};

/// A grid of panels with one legend to the right of them. Text is plain UTF-8: underscores stay underscores.
struct Chart {
  std::string name = {};  ///< file name without extension: letters, digits, '_' and '-'
  std::string title = {};
  std::string caption = {};  ///< one sentence under the chart on the page: what to see
  std::vector<Panel> panels = {};
  int grid_columns = 2;
};

/// One series per distinct text of column `group`, for the rows that `keep` accepts. Rows whose `status` is
/// not "ok" become failed runs; `reference_error`, where the table has it, becomes the floor if y is the
/// column `error`.
std::vector<Series> series_by(const Table& table, std::string_view group, std::string_view x,
                              std::string_view y, const std::function<bool(std::size_t row)>& keep = {});

/// The gnuplot script, data included. Values that cannot be drawn (not finite; not positive on a log axis)
/// never reach it: their number is written under the chart. MisuseError for unequal lengths or a bad name.
std::string gnuplot_script(const Chart& chart);

/// Writes <name>.gp and <name>.svg into the folder, each atomically. Throws IoError (gnuplot missing or
/// failing too).
void draw(const Chart& chart, const std::filesystem::path& folder);

}  // namespace feder::experiments
