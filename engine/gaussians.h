#pragma once

#include "engine/state.h"

namespace feder {

/// A sum of isotropic Gaussians in R^d (notes I1),
///
///     f(x) = sum_k w_k exp(-|x - m_k|^2 / (2 s_k^2)),      s_k = exp(l_k).
///
/// The width is kept as its logarithm l: s > 0 whatever a step of a fit adds to it, a change of l is
/// relative, and nothing overflows in high dimension. A derivative by s is that by l, divided by s.
struct GaussianSum {
  int dimension = 0;    ///< d
  VectorXd parameters;  ///< per Gaussian d + 2 numbers: weight w, centre m, log width l

  /// InputError unless d >= 1.
  explicit GaussianSum(int d);
  /// Appends one. InputError for a weight or centre that is not finite, a centre not of dimension d, or a
  /// width outside (0, inf) or exp(+-kMostLogWidth).
  void add(double weight, const VectorXd& centre, double width);

  int stride() const { return dimension + 2; }
  int count() const { return static_cast<int>(parameters.size()) / stride(); }
  double weight(int k) const { return parameters[k * stride()]; }
  auto centre(int k) const { return parameters.segment(k * stride() + 1, dimension); }
  double log_width(int k) const { return parameters[k * stride() + dimension + 1]; }
};

/// Largest |l|, so that squares of widths stay in range.
inline constexpr double kMostLogWidth = 300.0;

/// Whether every parameter is finite and every |l| <= kMostLogWidth: then no function below gives a NaN.
bool in_range(const GaussianSum& sum);

/// f(x), x of dimension d. gradient: null, or room for the derivatives by `parameters`.
double evaluate(const GaussianSum& sum, const Eigen::Ref<const VectorXd>& x, double* gradient = nullptr);

/// The integral over R^d of the product of two Gaussians of height 1, and the derivatives of its *logarithm*:
/// the integral itself leaves the range of a double from d of a few hundred on.
struct GaussianOverlap {
  double log_value = 0.0;  ///< -infinity where the distance is beyond all range
  VectorXd by_centre_a;    ///< by_centre_b is the negative
  double by_log_width_a = 0.0, by_log_width_b = 0.0;

  double value() const;  ///< 0 or infinity out of range
};
GaussianOverlap overlap(const Eigen::Ref<const VectorXd>& centre_a, double log_width_a,
                        const Eigen::Ref<const VectorXd>& centre_b, double log_width_b);

/// mantissa exp(log_scale), for numbers that a double may not hold.
struct ScaledValue {
  double mantissa = 0.0, log_scale = 0.0;

  double value() const;  ///< 0 or +-infinity out of range
};

/// The integral over R^d of the product of two sums of one dimension, scaled by its largest term. gradient_a:
/// null, or derivatives by the parameters of a, to be scaled by exp(log_scale) as well.
ScaledValue overlap(const GaussianSum& a, const GaussianSum& b, VectorXd* gradient_a = nullptr);

}  // namespace feder
