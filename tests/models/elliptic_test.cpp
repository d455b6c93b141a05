// The independent check integrates sn' = cn dn, cn' = -sn dn, dn' = -k^2 sn cn by Taylor series in long
// double.
#include "models/elliptic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace feder {
namespace {

using Real = long double;
constexpr int kOrder = 24;

struct Triple {
  Real s = 0, c = 1, d = 1;
};

// one Taylor step of length dt
Triple step(const Triple& start, Real k2, Real dt) {
  std::array<Real, kOrder + 1> s{}, c{}, d{};
  s[0] = start.s, c[0] = start.c, d[0] = start.d;
  for (int m = 0; m < kOrder; ++m) {
    Real cd = 0, sd = 0, sc = 0;
    for (int i = 0; i <= m; ++i) cd += c[i] * d[m - i], sd += s[i] * d[m - i], sc += s[i] * c[m - i];
    s[m + 1] = cd / (m + 1), c[m + 1] = -sd / (m + 1), d[m + 1] = -k2 * sc / (m + 1);
  }
  Triple end{s[kOrder], c[kOrder], d[kOrder]};
  for (int m = kOrder - 1; m >= 0; --m) end = {end.s * dt + s[m], end.c * dt + c[m], end.d * dt + d[m]};
  return end;
}

Modulus of_angle(double angle) {
  return {std::sin(0.5 * angle), std::cos(0.5 * angle)};
}

TEST(Elliptic, FunctionsAgreeWithTaylorIntegration) {
  double worst = 0.0;
  for (double angle : {0.01, 0.5, 1.0, 2.0, 3.0, 3.1, 3.14}) {
    const Modulus modulus = of_angle(angle);
    const Real k2 = 1 - static_cast<Real>(modulus.complement) * modulus.complement;
    Triple y;
    for (int i = 1; i <= 320; ++i) {
      y = step(y, k2, Real(1) / 32);
      const JacobiElliptic e = jacobi_elliptic(i / 32.0, modulus);
      worst =
          std::max({worst, std::abs(e.sn - static_cast<double>(y.s)),
                    std::abs(e.cn - static_cast<double>(y.c)), std::abs(e.dn - static_cast<double>(y.d))});
    }
  }
  EXPECT_GT(worst, 0.0);
  EXPECT_LT(worst, 1e-13);  // 3.5e-15
}

TEST(Elliptic, CompleteIntegralAgreesWithTrapezoidalSum) {
  // periodic integrand: the sum converges like exp(-2 points asinh(k'))
  double worst = 0.0;
  for (double angle : {0.01, 0.5, 1.0, 2.0, 3.0, 3.1}) {
    const Modulus modulus = of_angle(angle);
    const Real k2 = 1 - static_cast<Real>(modulus.complement) * modulus.complement;
    const int points = 4000;
    Real sum = 0;
    for (int i = 0; i < points; ++i) {
      const Real s = std::sin((i + Real(0.5)) * std::numbers::pi_v<Real> / 2 / points);
      sum += 1 / std::sqrt(1 - k2 * s * s);
    }
    const Real K = sum * std::numbers::pi_v<Real> / 2 / points;
    worst = std::max(worst, std::abs(static_cast<double>(elliptic_k(modulus) / K - 1)));
  }
  EXPECT_LT(worst, 1e-15);  // 2.1e-16
}

TEST(Elliptic, SmallModulusGivesCircularFunctions) {
  const JacobiElliptic e = jacobi_elliptic(0.7, {0.0, 1.0});
  EXPECT_DOUBLE_EQ(e.sn, std::sin(0.7));
  EXPECT_DOUBLE_EQ(e.cn, std::cos(0.7));
  EXPECT_DOUBLE_EQ(e.dn, 1.0);
}

TEST(Elliptic, ModulusNearOneGivesHyperbolicFunctions) {
  const JacobiElliptic e = jacobi_elliptic(2.0, {1.0, 1e-12});
  EXPECT_NEAR(e.sn, std::tanh(2.0), 1e-14);
  EXPECT_NEAR(e.cn, 1.0 / std::cosh(2.0), 1e-14);
  EXPECT_NEAR(e.dn, 1.0 / std::cosh(2.0), 1e-14);
}

}  // namespace
}  // namespace feder
