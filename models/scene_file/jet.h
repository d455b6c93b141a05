// Truncated Taylor arithmetic along one line: g(s) = value + first s + second s^2/2 + ...
//   f(g)' = f'(g) g',   f(g)'' = f''(g) g'^2 + f'(g) g''
#pragma once

#include <cmath>

namespace feder {

/// Value, first and second derivative along a line. Exact: no step size, rounding only.
struct Jet {
  double value = 0.0, first = 0.0, second = 0.0;
  bool varies = false;  ///< false: a constant, whose derivatives stay 0 even through an infinite slope
};

inline Jet operator-(const Jet& a) {
  return {-a.value, -a.first, -a.second, a.varies};
}

inline Jet operator+(const Jet& a, const Jet& b) {
  return {a.value + b.value, a.first + b.first, a.second + b.second, a.varies || b.varies};
}

inline Jet operator-(const Jet& a, const Jet& b) {
  return {a.value - b.value, a.first - b.first, a.second - b.second, a.varies || b.varies};
}

inline Jet operator*(const Jet& a, const Jet& b) {
  if (!a.varies) return {a.value * b.value, a.value * b.first, a.value * b.second, b.varies};
  if (!b.varies) return b * a;
  return {a.value * b.value, a.first * b.value + a.value * b.first,
          a.second * b.value + 2.0 * a.first * b.first + a.value * b.second, true};
}

inline Jet operator/(const Jet& a, const Jet& b) {
  const double value = a.value / b.value;
  if (!b.varies) return {value, a.first / b.value, a.second / b.value, a.varies};
  const double first = (a.first - value * b.first) / b.value;
  return {value, first, (a.second - 2.0 * first * b.first - value * b.second) / b.value, true};
}

/// f(g) from f, f', f'' at g.value. An f' that is infinite is handed on, a value that is none takes its
/// derivatives with it.
inline Jet chain(const Jet& g, double f, double f1, double f2) {
  if (!g.varies) return {f};
  if (std::isnan(f)) return {f, f, f, true};
  const double bend = g.second == 0.0 && g.first != 0.0 ? 0.0 : f1 * g.second;
  return {f, f1 * g.first, f2 * g.first * g.first + bend, true};
}

/// a^b. With a constant exponent any base std::pow takes; with a varying one a > 0, else the derivatives are
/// NaN.
inline Jet power(const Jet& a, const Jet& b) {
  const double c = b.value, value = std::pow(a.value, c);
  if (!b.varies)
    return chain(a, value, c == 0.0 ? 0.0 : c * std::pow(a.value, c - 1.0),
                 c == 0.0 || c == 1.0 ? 0.0 : c * (c - 1.0) * std::pow(a.value, c - 2.0));
  // p = b ln a:  (e^p)' = e^p p',  (e^p)'' = e^p (p'' + p'^2)
  const double x = a.value;
  const Jet p = b * chain(a, std::log(x), 1.0 / x, -1.0 / (x * x));
  return {value, value * p.first, value * (p.second + p.first * p.first), true};
}

/// The angle of (x, y), in (-pi, pi].
inline Jet atan2(const Jet& y, const Jet& x) {
  const double value = std::atan2(y.value, x.value);
  if (!y.varies && !x.varies) return {value};
  const double square = x.value * x.value + y.value * y.value;
  const double first = (x.value * y.first - y.value * x.first) / square;
  const double growth = 2.0 * (x.value * x.first + y.value * y.first) / square;
  return {value, first, (x.value * y.second - y.value * x.second) / square - first * growth, true};
}

}  // namespace feder
