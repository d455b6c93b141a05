#pragma once

#include <vector>

#include "experiments/support/chart.h"

namespace feder::experiments {

/// One axis with its final limits. `log` axes work in decades, so "fraction" means distance on paper.
struct Range {
  double lo = 0;
  double hi = 1;
  bool log = false;

  /// The value at a fraction of the axis: 0 at lo, 1 at hi.
  double at(double fraction) const;
  /// Inverse of at().
  double fraction(double value) const;
};

/// Whether gnuplot can place the value: finite, not near overflow, positive on a log axis.
bool drawable(const Axis& axis, double value);

bool drawable(const Panel& panel, const Series& series, std::size_t i);

/// Whether the point lies above the judge's own error.
bool trusted(const Series& series, std::size_t i);

struct PanelRanges {
  Range x;
  Range y;
  bool empty = false;      ///< nothing can be drawn
  double failed_from = 1;  ///< fraction of the height above which the rows of crosses for failed runs lie
};

/// Limits that hold every drawable value with a small margin, and room on top for the crosses of failed runs.
PanelRanges ranges_of(const Panel& panel);

/// Whether the series has a failed run whose cross can be drawn.
bool has_failures(const Panel& panel, const Series& series);

/// Number of points and failed runs of the panel that cannot be drawn.
long undrawable_points(const Panel& panel);

}  // namespace feder::experiments
