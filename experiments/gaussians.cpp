// How few Gaussians describe a curve (notes I1)? Least squares on samples of [-1, 1]; one more Gaussian
// starts where the last fit is worst, with the best of a few widths, then all are fitted together. The number
// to look for is the first after which the rms error only follows the noise.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/check.h"
#include "experiments/support/experiment.h"
#include "experiments/support/timing.h"
#include "solvers/gaussian_fit.h"

namespace feder::experiments {
namespace {

constexpr double kTolerance = 1e-6;  // of a fit: cosine between residual and gradient

struct Curve {
  const char* name;
  double (*value)(double x);
};

double three_gaussians(double x) {
  return std::exp(-0.5 * std::pow((x + 0.5) / 0.12, 2)) + 0.6 * std::exp(-0.5 * std::pow(x / 0.25, 2)) -
         0.4 * std::exp(-0.5 * std::pow((x - 0.5) / 0.08, 2));
}
constexpr Curve kCurves[] = {{"three Gaussians", three_gaussians},
                             {"Runge", [](double x) { return 1.0 / (1.0 + 25.0 * x * x); }},
                             {"hat", [](double x) { return std::max(0.0, 1.0 - 2.0 * std::abs(x)); }},
                             {"box", [](double x) { return std::abs(x) < 0.5 ? 1.0 : 0.0; }}};

struct Samples {
  Eigen::MatrixXd points;  // 1 x count
  VectorXd values;
};

// Noise: the golden ratio's multiples, uniform in [-1, 1] and the same everywhere.
Samples sample(const Curve& curve, int count, double noise, std::uint64_t seed) {
  Samples out{Eigen::MatrixXd(1, count), VectorXd(count)};
  for (int i = 0; i < count; ++i) {
    const double x = -1.0 + 2.0 * i / (count - 1.0);
    const double turn = std::fmod(static_cast<double>(seed + 7919 * i) * 0.61803398874989485, 1.0);
    out.points(0, i) = x;
    out.values[i] = curve.value(x) + noise * (2.0 * turn - 1.0);
  }
  return out;
}

// The best fit with one Gaussian more.
GaussianFit grow(const Samples& samples, GaussianSum& sum, int most_steps) {
  Eigen::Index worst = 0;
  VectorXd left = samples.values;
  for (Eigen::Index i = 0; i < left.size(); ++i) left[i] -= evaluate(sum, samples.points.col(i));
  left.cwiseAbs().maxCoeff(&worst);
  std::optional<GaussianFit> best;
  GaussianSum best_sum = sum;
  for (const double width : {0.4, 0.2, 0.1, 0.05, 0.02}) {
    GaussianSum next = sum;
    next.add(left[worst], samples.points.col(worst), width);
    const GaussianFit fit = fit_gaussians(samples.points, samples.values, next,
                                          {.most_steps = most_steps, .tolerance = kTolerance});
    if (!best || fit.rms < best->rms) best = fit, best_sum = next;
  }
  sum = best_sum;
  return *best;
}

Series drawn(const std::string& label, const Samples& samples, const GaussianSum* sum, std::size_t look) {
  Series series{.label = label, .look = look, .markers = false, .theory = !sum};
  for (Eigen::Index i = 0; i < samples.values.size(); ++i)
    series.add(samples.points(0, i), sum ? evaluate(*sum, samples.points.col(i)) : samples.values[i]);
  return series;
}

void body(Context& context) {
  const int most = static_cast<int>(context.settings.integer("gaussians")),
            count = static_cast<int>(context.settings.integer("points")),
            most_steps = static_cast<int>(context.settings.integer("steps"));
  const double noise = context.settings.number("noise");
  if (most < 1) fail_input("gaussians", "gaussians", most, "", "at least 1");
  if (count < 2) fail_input("gaussians", "points", count, "", "at least 2");
  require_non_negative("gaussians", "noise", noise, "");
  const double floor = std::max(noise / std::sqrt(3.0), 1e-14);
  Panel errors{.title = "error of the fit",
               .x = {"number of Gaussians [1]"},
               .y = {.label = "rms error [1]", .log = true},
               .marks = {{.at = floor, .label = "rms of the noise", .vertical = false}}},
      curves{.title = "the box and its fits", .x = {"x [1]"}, .y = {"f [1]"}};
  context.progress.start(static_cast<long>(std::size(kCurves)) * most);
  for (const Curve& curve : kCurves) {
    const Samples samples = sample(curve, count, noise, context.seed);
    const bool shown = &curve == std::end(kCurves) - 1;
    if (shown) curves.series.push_back(drawn("box, samples", samples, nullptr, 0));
    Series series{.label = curve.name};
    GaussianSum sum(1);
    int enough = 0;
    for (int k = 1; k <= most; ++k) {
      if (context.interrupted()) return;
      const Stopwatch watch;
      const GaussianFit fit = grow(samples, sum, most_steps);
      series.add(k, fit.rms);
      if (!enough && fit.rms < 1.1 * floor) enough = k;
      context.table.add({{"scene", curve.name},
                         {"gaussians", k},
                         {"status", to_string(fit.status.code)},
                         {"reason", fit.status.reason},
                         {"steps", fit.steps},
                         {"rms", fit.rms},
                         {"gradient", fit.gradient},
                         {"seconds", watch.seconds()}});
      context.progress.advance(fmt::format("{} {}", curve.name, k));
      // looks that no curve of the other panel has; the last fit as a full line
      const std::size_t look = k == most ? 5 : k == 1 ? 4 : 7;
      if (shown && (k == 1 || k == 3 || k == most))
        curves.series.push_back(
            drawn(fmt::format("{} Gaussian{}", k, k > 1 ? "s" : ""), samples, &sum, look));
    }
    context.note(enough ? fmt::format("{}: {} Gaussians reach the noise.", curve.name, enough)
                        : fmt::format("{}: {} Gaussians do not reach the noise, they leave {:.1e}.",
                                      curve.name, most, series.y.back()));
    errors.series.push_back(std::move(series));
  }
  context.add_chart({.name = "gaussians",
                     .title = "How few Gaussians describe a curve?",
                     .caption =
                         "Smooth curves need few until only the noise of the samples is left, a kink needs "
                         "more, a jump ever more: next to it the sum overshoots.",
                     .panels = {std::move(errors), std::move(curves)}});
}

ExperimentInfo info() {
  return {.name = "gaussians",
          .question = "How few Gaussians describe this curve?",
          .not_modelled = "Each fit is a local minimum; another start may find a better one.",
          .settings = {{"gaussians", Kind::kInteger, "8", "14", "largest number of Gaussians"},
                       {"points", Kind::kInteger, "201", "1001", "samples of [-1, 1]"},
                       {"noise", Kind::kNumber, "1e-4", "1e-6", "uniform between - and + this"},
                       {"steps", Kind::kInteger, "1000", "3000", "most steps of a fit"}},
          .columns = {"scene", "gaussians", "status", "reason", "steps", "rms", "gradient", "seconds"},
          .cases = {"three Gaussians, Runge, hat, box"}};
}

}  // namespace
}  // namespace feder::experiments

int main(int argc, char** argv) {
  return feder::experiments::run_experiment(feder::experiments::info(), argc, argv, feder::experiments::body);
}
