#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "experiments/support/chart.h"

namespace feder::experiments {

/// Look of one series. Colour, marker and dash all differ between neighbours: each alone tells them apart.
struct SeriesStyle {
  std::string colour;  ///< "#rrggbb", Okabe-Ito palette
  int solid_marker = 7;
  int open_marker = 6;
  std::string dash;
  double width = 2;
  double size = 0.9;  ///< of markers

  // gnuplot's "with ..." for each part of a series.
  std::string lines() const;
  std::string solid_points() const;
  std::string blank_points()
      const;  ///< white, drawn under the open marker so that the line does not cross it
  std::string open_points() const;
  std::string failed_points() const;
};

/// Styles by label, in order of first appearance in the chart.
class StyleBook {
 public:
  explicit StyleBook(const Chart& chart);

  SeriesStyle style(const Series& series) const;
  /// One series per label, in legend order.
  const std::vector<const Series*>& legend() const { return legend_; }

 private:
  std::vector<const Series*> legend_;
};

/// A quoted gnuplot string that shows the text as it is: no subscripts, no commands, control characters
/// become spaces.
std::string gnuplot_text(std::string_view text);

}  // namespace feder::experiments
