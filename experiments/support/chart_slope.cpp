#include "experiments/support/chart_slope.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace feder::experiments {
namespace {

constexpr double kGap = 0.05;        // distance below the curve, as a fraction of the height
constexpr double kEqualSlope = 0.2;  // closer slopes count as equal, then the lower curve wins

/// Decimal logarithms of the trusted points of one series, by growing x.
using Points = std::vector<std::pair<double, double>>;

Points trusted_points(const Panel& panel, const Series& series) {
  Points points;
  for (std::size_t i = 0; i < series.x.size() && !series.theory; ++i) {
    if (drawable(panel, series, i) && trusted(series, i)) {
      points.emplace_back(std::log10(series.x[i]), std::log10(series.y[i]));
    }
  }
  std::sort(points.begin(), points.end());
  return points;
}

std::pair<double, double> mean(const Points& points) {
  double x = 0;
  double y = 0;
  for (const auto& [px, py] : points) x += px, y += py;
  const double n = static_cast<double>(points.size());
  return {x / n, y / n};
}

/// Least squares slope; NaN for fewer than two distinct x.
double fitted_slope(const Points& points) {
  const auto [x, y] = mean(points);
  double xx = 0;
  double xy = 0;
  for (const auto& [px, py] : points) {
    xx += (px - x) * (px - x);
    xy += (px - x) * (py - y);
  }
  return xx > 0 ? xy / xx : std::numeric_limits<double>::quiet_NaN();
}

/// The points of the series whose slope is nearest to `order`; the lowest such series.
Points nearest_points(const Panel& panel, double order) {
  Points best;
  double best_distance = std::numeric_limits<double>::infinity();
  for (const Series& series : panel.series) {
    const Points points = trusted_points(panel, series);
    const double distance = std::max(kEqualSlope, std::abs(fitted_slope(points) - order));
    const bool lower = distance == best_distance && mean(points).second < mean(best).second;
    if (!(distance < best_distance) && !lower) continue;
    best_distance = distance;
    best = points;
  }
  return best;
}

/// The straight line through (x1, y1), both as logarithms, from x0 to x1.
SlopeLine line_through(const PanelRanges& ranges, double order, double x0, double x1, double y1) {
  const auto x = [&](double logarithm) { return ranges.x.fraction(std::pow(10, logarithm)); };
  const auto y = [&](double logarithm) { return ranges.y.fraction(std::pow(10, logarithm)); };
  const double bottom = std::log10(ranges.y.at(0.03));
  if (order > 0 && y1 > bottom) x0 = std::max(x0, x1 - (y1 - bottom) / order);
  return {x(x0), y(y1 - order * (x1 - x0)), x(x1), y(y1), x1 > x0 && y1 > bottom};
}

}  // namespace

SlopeLine place_slope(const Panel& panel, const PanelRanges& ranges, const Slope& slope) {
  if (slope.x && slope.y && drawable(panel.x, *slope.x) && drawable(panel.y, *slope.y)) {
    const double third = std::log10(ranges.x.hi / ranges.x.lo) / 3;
    const double x1 = std::log10(*slope.x);
    return line_through(ranges, slope.order, x1 - third, x1, std::log10(*slope.y));
  }
  const Points points = nearest_points(panel, slope.order);
  if (points.empty()) return {};
  // Beside the upper half of the curve, under its lowest point there.
  const double x1 = points.back().first;
  const double x0 = 0.5 * (points.front().first + x1);
  double offset = std::numeric_limits<double>::infinity();
  for (const auto& [px, py] : points) {
    if (px >= x0) offset = std::min(offset, py - slope.order * px);
  }
  const double gap = kGap * std::log10(ranges.y.hi / ranges.y.lo);
  return line_through(ranges, slope.order, x0, x1, offset + slope.order * x1 - gap);
}

}  // namespace feder::experiments
