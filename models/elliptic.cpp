// Elliptic functions by the arithmetic-geometric mean (Abramowitz and Stegun 16.4, 17.6):
//   a_0 = 1, b_0 = k', c_0 = k;  a_next = (a + b) / 2, b_next = sqrt(a b), c_next = c^2 / (4 a_next)
//   K = pi / (2 a_N);  phi_N = 2^N a_N u,  phi_(n-1) = (phi_n + asin(c_n / a_n sin phi_n)) / 2
//   sn = sin phi_0, cn = cos phi_0, dn^2 = k'^2 + k^2 cn^2
#include "models/elliptic.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace feder {
namespace {

// c shrinks quadratically: 16 levels reach rounding for every k' a double can hold.
constexpr int kLevels = 16;

struct Mean {
  std::array<double, kLevels + 1> a{}, c{};
  int last = 0;
};

Mean arithmetic_geometric_mean(const Modulus& modulus) {
  Mean mean;
  mean.a[0] = 1.0;
  mean.c[0] = modulus.k;
  double b = modulus.complement;
  int n = 0;
  while (n < kLevels && mean.c[n] > 0.1 * std::numeric_limits<double>::epsilon() * mean.a[n]) {
    const double a = mean.a[n];
    ++n;
    mean.a[n] = 0.5 * (a + b);
    mean.c[n] = mean.c[n - 1] * mean.c[n - 1] / (4.0 * mean.a[n]);
    b = std::sqrt(a * b);
  }
  mean.last = n;
  return mean;
}

}  // namespace

double elliptic_k(const Modulus& modulus) {
  const Mean mean = arithmetic_geometric_mean(modulus);
  return std::numbers::pi / (2.0 * mean.a[mean.last]);
}

JacobiElliptic jacobi_elliptic(double u, const Modulus& modulus) {
  const Mean mean = arithmetic_geometric_mean(modulus);
  double phi = std::ldexp(mean.a[mean.last] * u, mean.last);
  for (int n = mean.last; n > 0; --n) phi = 0.5 * (phi + std::asin(mean.c[n] / mean.a[n] * std::sin(phi)));
  const double cn = std::cos(phi);
  return {std::sin(phi), cn, std::hypot(modulus.complement, modulus.k * cn)};
}

}  // namespace feder
