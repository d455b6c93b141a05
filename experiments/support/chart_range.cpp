#include "experiments/support/chart_range.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace feder::experiments {
namespace {

constexpr double kLargest = 1e300;   // sums and differences of drawable values stay finite
constexpr double kMargin = 0.05;     // free space beside the data, as a fraction of the axis
constexpr double kFailedRow = 0.05;  // height of one row of crosses
constexpr double kFarBelow = 1e-4;   // a floor this much below the data does not stretch the axis
constexpr double kNone = std::numeric_limits<double>::infinity();

/// Smallest and largest drawable value seen so far.
struct Extent {
  double lo = kNone;
  double hi = -kNone;

  void include(const Axis& axis, double value) {
    if (!drawable(axis, value)) return;
    lo = std::min(lo, value);
    hi = std::max(hi, value);
  }
  bool empty() const { return lo > hi; }
};

Range padded(const Axis& axis, Extent extent) {
  if (extent.empty()) extent = axis.log ? Extent{0.1, 10} : Extent{0, 1};
  const auto to_paper = [&](double v) { return axis.log ? std::log10(v) : v; };
  const double lo = to_paper(extent.lo);
  const double hi = to_paper(extent.hi);
  double width = hi - lo;
  // A single value still needs an axis around it.
  if (!(width > 1e-12 * std::max(std::abs(lo), std::abs(hi))))
    width = axis.log ? 1 : std::max(1e-6, std::abs(lo));
  const double pad = (hi - lo < width) ? 0.5 * width : kMargin * width;
  const auto from_paper = [&](double p) { return axis.log ? std::pow(10, std::clamp(p, -300.0, 300.0)) : p; };
  Range range{from_paper(lo - pad), from_paper(hi + pad), axis.log};
  if (axis.min) range.lo = *axis.min;
  if (axis.max) range.hi = *axis.max;
  return range;
}

long failing_series(const Panel& panel) {
  return std::count_if(panel.series.begin(), panel.series.end(),
                       [&](const Series& series) { return has_failures(panel, series); });
}

}  // namespace

double Range::at(double fraction_of_axis) const {
  if (!log) return std::lerp(lo, hi, fraction_of_axis);
  return std::pow(10, std::lerp(std::log10(lo), std::log10(hi), fraction_of_axis));
}

double Range::fraction(double value) const {
  if (!log) return (value - lo) / (hi - lo);
  return std::log10(value / lo) / std::log10(hi / lo);
}

bool drawable(const Axis& axis, double value) {
  return std::isfinite(value) && std::abs(value) < kLargest && (!axis.log || value > 1 / kLargest);
}

bool drawable(const Panel& panel, const Series& series, std::size_t i) {
  return drawable(panel.x, series.x[i]) && drawable(panel.y, series.y[i]);
}

bool trusted(const Series& series, std::size_t i) {
  return series.floor.empty() || series.y[i] >= series.floor[i];
}

bool has_failures(const Panel& panel, const Series& series) {
  return std::any_of(series.failed_x.begin(), series.failed_x.end(),
                     [&](double value) { return drawable(panel.x, value); });
}

PanelRanges ranges_of(const Panel& panel) {
  Extent x;
  Extent y;
  for (const Series& series : panel.series) {
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (!drawable(panel, series, i)) continue;
      x.include(panel.x, series.x[i]);
      y.include(panel.y, series.y[i]);
    }
    for (const double failed : series.failed_x) x.include(panel.x, failed);
  }
  PanelRanges ranges;
  ranges.empty = x.empty();
  for (const Mark& mark : panel.marks)
    mark.vertical ? x.include(panel.x, mark.at) : y.include(panel.y, mark.at);
  if (panel.judge_error && (y.empty() || *panel.judge_error > kFarBelow * y.lo))
    y.include(panel.y, *panel.judge_error);
  ranges.x = padded(panel.x, x);
  ranges.y = padded(panel.y, y);
  if (const long failing = failing_series(panel); failing > 0) {
    const double strip = std::min(0.4, kFailedRow * static_cast<double>(failing) + 0.01);
    ranges.y.hi = ranges.y.at(1 / (1 - strip));
    ranges.failed_from = 1 - strip;
  }
  return ranges;
}

long undrawable_points(const Panel& panel) {
  long count = 0;
  for (const Series& series : panel.series) {
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (!drawable(panel, series, i)) ++count;
    }
    count += std::count_if(series.failed_x.begin(), series.failed_x.end(),
                           [&](double value) { return !drawable(panel.x, value); });
  }
  return count;
}

}  // namespace feder::experiments
