#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "experiments/support/chart_range.h"

namespace feder::experiments {

/// Where a label could go: a point (fractions of the axes) and which way the text runs from there.
struct LabelPlace {
  double x = 0;
  double y = 0;
  int direction = 1;  ///< 1 text starts at the point, -1 text ends there
  bool upright = false;

  /// gnuplot's words for the direction.
  std::string how() const;
};

/// Knows where the curves of a panel run, to keep labels away from them.
class FreeSpace {
 public:
  FreeSpace(const Panel& panel, const PanelRanges& ranges);

  /// The place where the text stays farthest from all curves and earlier labels; the first of equals.
  LabelPlace choose(std::string_view text, const std::vector<LabelPlace>& places);

 private:
  double distance(std::string_view text, const LabelPlace& place) const;

  std::vector<std::pair<double, double>> points_;
};

}  // namespace feder::experiments
