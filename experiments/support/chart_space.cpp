#include "experiments/support/chart_space.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace feder::experiments {
namespace {

// Size of a letter in fractions of a panel of usual size, and how far away counts as free.
constexpr double kLetterWidth = 0.017;
constexpr double kLetterHeight = 0.05;
constexpr double kFarEnough = 0.06;
constexpr int kPerSegment = 8;

}  // namespace

std::string LabelPlace::how() const {
  return std::string(direction > 0 ? "left" : "right") + (upright ? " rotate by 90" : "");
}

FreeSpace::FreeSpace(const Panel& panel, const PanelRanges& ranges) {
  for (const Series& series : panel.series) {
    std::vector<std::pair<double, double>> curve;
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (!drawable(panel, series, i)) continue;
      curve.emplace_back(ranges.x.fraction(series.x[i]), ranges.y.fraction(series.y[i]));
    }
    // Points in between stand for the line.
    for (std::size_t i = 0; i + 1 < curve.size() && series.line; ++i) {
      for (int k = 1; k < kPerSegment; ++k) {
        const double t = static_cast<double>(k) / kPerSegment;
        points_.emplace_back(std::lerp(curve[i].first, curve[i + 1].first, t),
                             std::lerp(curve[i].second, curve[i + 1].second, t));
      }
    }
    points_.insert(points_.end(), curve.begin(), curve.end());
  }
}

double FreeSpace::distance(std::string_view text, const LabelPlace& place) const {
  const double length = kLetterWidth * static_cast<double>(text.size());
  const double width = place.upright ? kLetterHeight : length;
  const double height = place.upright ? length : kLetterHeight;
  const double x = place.x + (place.upright ? 0 : 0.5 * place.direction * width);
  const double y = place.y + (place.upright ? 0.5 * place.direction * height : 0);
  const auto outside = [](double centre, double extent) {
    return std::max(0.0, std::abs(centre - 0.5) + extent / 2 - 0.5);
  };
  if (outside(x, width) > 0.01 || outside(y, height) > 0.01) return -1;
  double nearest = kFarEnough;
  for (const auto& [px, py] : points_) {
    const double dx = std::max(0.0, std::abs(px - x) - width / 2);
    const double dy = std::max(0.0, std::abs(py - y) - height / 2);
    nearest = std::min(nearest, std::hypot(dx, dy));
  }
  return nearest;
}

LabelPlace FreeSpace::choose(std::string_view text, const std::vector<LabelPlace>& places) {
  LabelPlace best = places.front();
  double best_distance = -std::numeric_limits<double>::infinity();
  for (const LabelPlace& place : places) {
    const double here = distance(text, place);
    if (here <= best_distance) continue;
    best_distance = here;
    best = place;
  }
  // The label itself is taken space from now on.
  for (std::size_t i = 0; i <= text.size(); ++i) {
    const double along = kLetterWidth * static_cast<double>(i) * best.direction;
    points_.emplace_back(best.x + (best.upright ? 0 : along), best.y + (best.upright ? along : 0));
  }
  return best;
}

}  // namespace feder::experiments
