#pragma once

#include "experiments/support/chart_range.h"

namespace feder::experiments {

/// A reference line in fractions of the axes.
struct SlopeLine {
  double x0, y0, x1, y1;
  bool found = false;  ///< false when the panel has nothing to put the line beside
};

/// Puts the line at its anchor, or else just under the series of nearest slope. Both axes must be log.
SlopeLine place_slope(const Panel& panel, const PanelRanges& ranges, const Slope& slope);

}  // namespace feder::experiments
