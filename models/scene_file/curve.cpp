// Piecewise cubic Hermite, h = x1 - x0, u = (x - x0)/h, D = (y1 - y0)/h the secant:
//   y = y0 + h u (d0 + u (c + u b)),   c = 3 D - 2 d0 - d1,   b = d0 + d1 - 2 D
// Slopes d: at a point between secants D0, D1 of one sign their weighted harmonic mean
//   (w0 + w1)/d = w0/D0 + w1/D1,   w0 = 2 h1 + h0,  w1 = h1 + 2 h0
// and 0 otherwise; at the ends the three-point formula, 0 where its sign is not that of the secant and at
// most 3 times it (Fritsch and Carlson, SIAM J. Numer. Anal. 17, 1980: monotone if |d| <= 3 |D|; the mean
// from Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5, 1984).
#include "models/scene_file/curve.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/check.h"

namespace feder {
namespace {

struct Piece {
  double h, secant, c, b;
};

Piece piece_between(double x0, double x1, double y0, double y1, double d0, double d1) {
  const double h = x1 - x0, secant = (y1 - y0) / h;
  return {h, secant, 3.0 * secant - 2.0 * d0 - d1, d0 + d1 - 2.0 * secant};
}

double mean_slope(double h0, double h1, double D0, double D1) {
  if (!(D0 * D1 > 0.0)) return 0.0;
  const double w0 = 2.0 * h1 + h0, w1 = h1 + 2.0 * h0;
  return D0 == D1 ? D0 : (w0 + w1) / (w0 / D0 + w1 / D1);
}

/// At an end, h0 and D0 being those of the piece there.
double end_slope(double h0, double h1, double D0, double D1) {
  const double d = D0 + (D0 - D1) * (h0 / (h0 + h1));
  if (!(d * D0 > 0.0)) return 0.0;
  return D0 * D1 < 0.0 && std::abs(d) > 3.0 * std::abs(D0) ? 3.0 * D0 : d;
}

std::string point(const std::string& where, std::size_t i) {
  return where + ": point " + std::to_string(i);
}

void check_points(const std::string& where, const std::vector<double>& x, const std::vector<double>& y) {
  FEDER_CHECK(x.size() == y.size(), "one value per abscissa");
  if (x.size() < 2) fail_input(where, "points", static_cast<double>(x.size()), "", "at least 2");
  for (std::size_t i = 0; i < x.size(); ++i) {
    require_finite(point(where, i), "abscissa", x[i], "");
    require_finite(point(where, i), "value", y[i], "");
    if (i > 0 && !(x[i] > x[i - 1]))
      fail_input(point(where, i), "abscissa", x[i], "", "more than the one before");
    // the factor 10 leaves room for the coefficients
    if (i > 0 && !std::isfinite(10.0 * (y[i] - y[i - 1]) / (x[i] - x[i - 1])))
      fail_input(point(where, i), "value", y[i], "", "a finite slope from the point before");
  }
}

}  // namespace

Curve::Curve(const std::string& where, std::vector<double> abscissae, std::vector<double> values)
    : x_(std::move(abscissae)), y_(std::move(values)) {
  check_points(where, x_, y_);
  const std::size_t last = x_.size() - 1;
  std::vector<double> h(last), D(last);
  for (std::size_t i = 0; i < last; ++i) h[i] = x_[i + 1] - x_[i], D[i] = (y_[i + 1] - y_[i]) / h[i];
  slope_.assign(last + 1, D[0]);
  if (last > 1) {
    for (std::size_t i = 1; i < last; ++i) slope_[i] = mean_slope(h[i - 1], h[i], D[i - 1], D[i]);
    slope_[0] = end_slope(h[0], h[1], D[0], D[1]);
    slope_[last] = end_slope(h[last - 1], h[last - 2], D[last - 1], D[last - 2]);
  }
  integral_.assign(last + 1, 0.0);
  for (std::size_t i = 0; i < last; ++i)
    integral_[i + 1] =
        integral_[i] + h[i] * (0.5 * (y_[i] + y_[i + 1]) + h[i] / 12.0 * (slope_[i] - slope_[i + 1]));
}

std::size_t Curve::piece(double x) const {
  const auto right = std::upper_bound(x_.begin() + 1, x_.end() - 1, x);
  return static_cast<std::size_t>(right - x_.begin()) - 1;
}

Jet Curve::at(double x) const {
  if (x < x_.front()) return {y_.front() + slope_.front() * (x - x_.front()), slope_.front(), 0.0, true};
  if (x > x_.back()) return {y_.back() + slope_.back() * (x - x_.back()), slope_.back(), 0.0, true};
  const std::size_t i = piece(x);
  const auto [h, secant, c, b] = piece_between(x_[i], x_[i + 1], y_[i], y_[i + 1], slope_[i], slope_[i + 1]);
  if (x == x_[i + 1]) return {y_[i + 1], slope_[i + 1], (2.0 * c + 6.0 * b) / h, true};
  const double u = (x - x_[i]) / h;
  return {y_[i] + h * u * (slope_[i] + u * (c + u * b)), slope_[i] + u * (2.0 * c + 3.0 * u * b),
          (2.0 * c + 6.0 * u * b) / h, true};
}

double Curve::integral(double x) const {
  const double before = x - x_.front(), beyond = x - x_.back();
  if (before < 0.0) return before * (y_.front() + 0.5 * before * slope_.front());
  if (beyond > 0.0) return integral_.back() + beyond * (y_.back() + 0.5 * beyond * slope_.back());
  const std::size_t i = piece(x);
  const auto [h, secant, c, b] = piece_between(x_[i], x_[i + 1], y_[i], y_[i + 1], slope_[i], slope_[i + 1]);
  const double u = (x - x_[i]) / h;
  return integral_[i] + h * u * (y_[i] + h * u * (slope_[i] / 2.0 + u * (c / 3.0 + u * b / 4.0)));
}

}  // namespace feder
