// Two Gaussians of height 1, S = s_a^2 + s_b^2, D = m_a - m_b (notes I1; product of Gaussians, complete the
// square):
//   integral = (2 pi s_a^2 s_b^2 / S)^(d/2) exp(-D^2 / (2 S))
//   log      = d (log(2 pi)/2 + l_a + l_b - log(S)/2) - D^2 / (2 S)
//   by m_a   : -D / S,      by l_a: d s_b^2 / S + D^2 s_a^2 / S^2
#include "engine/gaussians.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "engine/check.h"

namespace feder {

GaussianSum::GaussianSum(int d) : dimension(d) {
  if (d < 1) fail_input("sum of Gaussians", "dimension", d, "", "at least 1");
}

void GaussianSum::add(double weight, const VectorXd& centre, double width) {
  const std::string place = "Gaussian " + std::to_string(count());
  require_finite(place, "weight", weight, "");
  if (centre.size() != dimension)
    fail_input(place, "numbers of the centre", static_cast<double>(centre.size()), "",
               "the dimension " + std::to_string(dimension));
  for (const double x : centre) require_finite(place, "centre", x, "");
  require_positive(place, "width", width, "");
  const double log_width = std::log(width);
  if (std::abs(log_width) > kMostLogWidth) fail_input(place, "width", width, "", "a size within exp(+-300)");
  const Eigen::Index old = parameters.size();
  parameters.conservativeResize(old + stride());
  parameters[old] = weight;
  parameters.segment(old + 1, dimension) = centre;
  parameters[old + dimension + 1] = log_width;
}

bool in_range(const GaussianSum& sum) {
  if (!sum.parameters.allFinite()) return false;
  for (int k = 0; k < sum.count(); ++k)
    if (std::abs(sum.log_width(k)) > kMostLogWidth) return false;
  return true;
}

double evaluate(const GaussianSum& sum, const Eigen::Ref<const VectorXd>& x, double* gradient) {
  FEDER_CHECK(x.size() == sum.dimension, "the point has the dimension of the sum");
  const int d = sum.dimension;
  double value = 0.0;
  for (int k = 0; k < sum.count(); ++k) {
    // g = exp(-z^2/2), z = |x - m|/s
    const double inverse = std::exp(-sum.log_width(k));
    double square = 0.0;
    for (int i = 0; i < d; ++i) {
      const double z = (x[i] - sum.centre(k)[i]) * inverse;
      square += z * z;
    }
    const double g = std::exp(-0.5 * square);
    value += sum.weight(k) * g;
    if (!gradient) continue;
    // by w: g;  by m: w g (x - m)/s^2;  by l: w g z^2
    double* at = gradient + k * sum.stride();
    const double slope = g > 0.0 ? sum.weight(k) * g : 0.0;
    at[0] = g;
    for (int i = 0; i < d; ++i)
      at[1 + i] = slope == 0.0 ? 0.0 : slope * ((x[i] - sum.centre(k)[i]) * inverse) * inverse;
    at[1 + d] = slope == 0.0 ? 0.0 : slope * square;
  }
  return value;
}

double GaussianOverlap::value() const {
  return std::exp(log_value);
}
double ScaledValue::value() const {
  return mantissa == 0.0 ? 0.0 : std::copysign(std::exp(std::log(std::abs(mantissa)) + log_scale), mantissa);
}

GaussianOverlap overlap(const Eigen::Ref<const VectorXd>& centre_a, double log_width_a,
                        const Eigen::Ref<const VectorXd>& centre_b, double log_width_b) {
  FEDER_CHECK(centre_a.size() == centre_b.size(), "both Gaussians have one dimension");
  const double d = static_cast<double>(centre_a.size());
  // shares s_a^2/S and s_b^2/S and the distance D/sqrt(S)
  const double s_a = std::exp(log_width_a), s_b = std::exp(log_width_b), root = std::hypot(s_a, s_b);
  const double share_a = (s_a / root) * (s_a / root), share_b = (s_b / root) * (s_b / root);
  const VectorXd distance = (centre_a - centre_b) / root;
  const double square = distance.squaredNorm();
  GaussianOverlap out;
  out.log_value = d * (0.5 * std::log(2.0 * std::numbers::pi) + log_width_a + log_width_b - std::log(root)) -
                  0.5 * square;
  out.by_centre_a = -distance / root;
  out.by_log_width_a = d * share_b + square * share_a;
  out.by_log_width_b = d * share_a + square * share_b;
  return out;
}

ScaledValue overlap(const GaussianSum& a, const GaussianSum& b, VectorXd* gradient_a) {
  FEDER_CHECK(a.dimension == b.dimension, "both sums have one dimension");
  const int d = a.dimension;
  // pairs that the sum does not see must not set its scale; a weight 0 of a has a derivative nevertheless
  const auto counts = [&](int i, int j) { return b.weight(j) != 0.0 && (gradient_a || a.weight(i) != 0.0); };
  std::vector<GaussianOverlap> pairs;
  double largest = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < a.count(); ++i)
    for (int j = 0; j < b.count(); ++j) {
      pairs.push_back(overlap(a.centre(i), a.log_width(i), b.centre(j), b.log_width(j)));
      if (counts(i, j)) largest = std::max(largest, pairs.back().log_value);
    }
  if (gradient_a) gradient_a->setZero(a.parameters.size());
  if (!std::isfinite(largest)) return {};
  // sum_ij w_i w_j exp(log_ij - largest)
  double sum = 0.0;
  for (int i = 0; i < a.count(); ++i)
    for (int j = 0; j < b.count(); ++j) {
      if (!counts(i, j)) continue;
      const GaussianOverlap& pair = pairs[i * b.count() + j];
      const double share = b.weight(j) * std::exp(pair.log_value - largest);
      if (share == 0.0) continue;
      sum += a.weight(i) * share;
      if (!gradient_a) continue;
      auto at = gradient_a->segment(i * a.stride(), a.stride());
      at[0] += share;
      at.segment(1, d) += a.weight(i) * share * pair.by_centre_a;
      at[1 + d] += a.weight(i) * share * pair.by_log_width_a;
    }
  return {sum, largest};
}

}  // namespace feder
