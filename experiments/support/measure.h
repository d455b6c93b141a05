// What several experiments measure in the same way.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "experiments/support/chart.h"
#include "models/model.h"
#include "solvers/integrators.h"

namespace feder::experiments {

/// When to look at the error [s]. Models with an exact solution end after whole periods, where an error of
/// phase hides: for them 7/8 of a period, where amplitude and phase both show.
inline double observation_time(const Model& model, int whole_periods = 0) {
  return model.exact ? (whole_periods / 2.0 + 7.0 / 16.0) * model.end_time : model.end_time;
}

/// What the scene can set in motion [J]: its energy at the start, and its weight falling through its length.
inline double energy_scale(const Model& model) {
  Vector3d weight = Vector3d::Zero();
  for (int i = 0; i < model.system.nodes; ++i)
    weight += Vector3d(model.system.forces.constant.segment<3>(3 * i));
  return kinetic_energy(model.system, model.state) + row_energy(model.system, model.state) +
         weight.norm() * model.scene_length;
}

/// Least-squares line y = offset + slope x with the standard error of its slope; NaN for fewer points than
/// needed.
struct Line {
  double slope = std::numeric_limits<double>::quiet_NaN();
  double slope_error = std::numeric_limits<double>::quiet_NaN();  ///< needs three points
  double offset = std::numeric_limits<double>::quiet_NaN();
};
inline Line fit_line(const std::vector<double>& x, const std::vector<double>& y) {
  const std::size_t n = x.size();
  if (n < 2) return {};
  double mean_x = 0.0, mean_y = 0.0, xx = 0.0, xy = 0.0, rest = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    mean_x += x[i] / static_cast<double>(n);
    mean_y += y[i] / static_cast<double>(n);
  }
  for (std::size_t i = 0; i < n; ++i) {
    xx += (x[i] - mean_x) * (x[i] - mean_x);
    xy += (x[i] - mean_x) * (y[i] - mean_y);
  }
  Line line;
  line.slope = xy / xx;
  line.offset = mean_y - line.slope * mean_x;
  for (std::size_t i = 0; i < n; ++i) rest += std::pow(y[i] - line.offset - line.slope * x[i], 2);
  if (n > 2) line.slope_error = std::sqrt(rest / (static_cast<double>(n - 2) * xx));
  return line;
}

/// The slope on log-log axes.
inline Line fit_power(std::vector<double> x, std::vector<double> y) {
  for (double& value : x) value = std::log(value);
  for (double& value : y) value = std::log(value);
  return fit_line(x, y);
}

/// Whether a linear route makes a difference to it: implicit, and solved for instead of swept over.
inline bool takes_routes(const IntegratorInfo& method) {
  return method.implicit && !method.iterative;
}

/// Gives the series whose labels are integrators the look of their place in the list.
inline std::vector<Series> with_integrator_looks(std::vector<Series> all) {
  const std::vector<IntegratorInfo> list = integrator_list();
  for (Series& series : all)
    for (std::size_t i = 0; i < list.size(); ++i)
      if (series.label == list[i].name) series.look = i;
  return all;
}

}  // namespace feder::experiments
