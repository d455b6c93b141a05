// Kernels (notes G2, G3): normalisation, slope, and what the printed one does at its border.
#include "engine/fluid/smoothing_kernel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "engine/check.h"

namespace feder {
namespace {

constexpr double kPi = std::numbers::pi;

// Gauss-Legendre with 8 points on each of the equal parts of [a, b].
double integral(const std::function<double(double)>& f, double a, double b, int parts) {
  constexpr double kAt[4] = {0.18343464249564980, 0.52553240991632899, 0.79666647741362674,
                             0.96028985649753623};
  constexpr double kWeight[4] = {0.36268378337836198, 0.31370664587788729, 0.22238103445337447,
                                 0.10122853629037626};
  double sum = 0.0;
  const double half = 0.5 * (b - a) / parts;
  for (int p = 0; p < parts; ++p) {
    const double middle = a + (2 * p + 1) * half;
    for (int i = 0; i < 4; ++i)
      sum += half * kWeight[i] * (f(middle - half * kAt[i]) + f(middle + half * kAt[i]));
  }
  return sum;
}

double surface(int dimension, double r) {
  return dimension == 1 ? 2.0 : dimension == 2 ? 2.0 * kPi * r : 4.0 * kPi * r * r;
}

template <class Visit>
void for_each_defined(Visit&& visit) {
  for (SmoothingKernel kernel : kSmoothingKernels)
    for (int dimension = 1; dimension <= 3; ++dimension)
      if (is_defined(kernel, dimension)) visit(kernel, dimension);
}

TEST(SmoothingKernel, IntegratesToOneInEveryDimensionItIsDefinedIn) {
  int checked = 0;
  for_each_defined([&](SmoothingKernel kernel, int dimension) {
    for (double h : {1.0, 0.037}) {
      // x = h s^2 takes the 1/r of the viscosity kernel
      const double sum = integral(
          [&](double s) {
            const double r = h * s * s;
            return surface(dimension, r) * kernel_value(kernel, dimension, h, r) * 2.0 * h * s;
          },
          0.0, 1.0, 64);
      EXPECT_NEAR(sum, 1.0, 1e-9) << to_string(kernel) << ' '
                                  << dimension;  // 4.1e-11 (cubic spline: its kink), others 9e-16
      ++checked;
    }
  });
  EXPECT_EQ(checked, 2 * (3 * 7 - 1));
}

TEST(SmoothingKernel, SlopeIsTheDerivative) {
  for_each_defined([](SmoothingKernel kernel, int dimension) {
    const double h = 0.7, step = 1e-5;
    double largest = 0.0;
    for (double r = 0.05; r < h - 3 * step; r += 0.0123) {
      auto W = [&](double at) { return kernel_value(kernel, dimension, h, at); };
      const double difference =
          (8.0 * (W(r + step) - W(r - step)) - (W(r + 2 * step) - W(r - 2 * step))) / (12.0 * step);
      const double slope = kernel_slope(kernel, dimension, h, r);
      EXPECT_NEAR(slope, difference, 1e-6 * std::abs(kernel_slope(kernel, dimension, h, 0.1)))
          << to_string(kernel);
      largest = std::max(largest, std::abs(slope));
    }
    EXPECT_GT(largest, 0.1);
  });
}

TEST(SmoothingKernel, FallsMonotonicallyToZeroAtItsSupport) {
  for_each_defined([](SmoothingKernel kernel, int dimension) {
    const double h = 0.4;
    for (double r = 0.01; r < h; r += 0.01) EXPECT_LE(kernel_slope(kernel, dimension, h, r), 0.0);
    EXPECT_NEAR(kernel_value(kernel, dimension, h, h * (1.0 - 1e-9)), 0.0, 1e-6) << to_string(kernel);
    EXPECT_EQ(kernel_value(kernel, dimension, h, h), 0.0);
    EXPECT_EQ(kernel_slope(kernel, dimension, h, 1.5 * h), 0.0);
  });
}

TEST(SmoothingKernel, SpikyPushesAtTheCentreAndTheOthersDoNot) {
  for (int dimension = 1; dimension <= 3; ++dimension) {
    EXPECT_LT(kernel_slope(SmoothingKernel::kSpiky, dimension, 1.0, 1e-9), -1.0);
    for (SmoothingKernel kernel :
         {SmoothingKernel::kPoly6, SmoothingKernel::kPoly6Printed, SmoothingKernel::kCubicSpline,
          SmoothingKernel::kWendland2, SmoothingKernel::kWendland4})
      EXPECT_NEAR(kernel_slope(kernel, dimension, 1.0, 1e-9), 0.0, 1e-6) << to_string(kernel);
  }
}

// Twins of notes G3: (h^2 - r^2)^3 as meant ends smoothly, (h^3 - r^3) as printed with a slope of -3 h^2.
TEST(SmoothingKernel, Poly6AsMeantEndsWithoutAJumpOfTheForce) {
  const double h = 0.3, inside = h * (1.0 - 1e-9);
  EXPECT_NEAR(kernel_slope(SmoothingKernel::kPoly6, 3, h, inside), 0.0, 1e-10);
}

TEST(SmoothingKernel, Poly6AsPrintedJumps) {
  const double h = 0.3, inside = h * (1.0 - 1e-9), norm = 3.0 / (2.0 * kPi * std::pow(h, 6));
  EXPECT_NEAR(kernel_slope(SmoothingKernel::kPoly6Printed, 3, h, inside) / norm, -3.0 * h * h, 1e-8);
  EXPECT_NEAR(kernel_value(SmoothingKernel::kPoly6Printed, 3, h, 0.1), norm * (h * h * h - 1e-3),
              1e-9 * norm);
}

TEST(SmoothingKernel, NormsAreThoseOfTheNotes) {
  const double h = 0.8;
  auto at_zero = [&](SmoothingKernel kernel, int dimension) {
    return kernel_value(kernel, dimension, h, 0.0);
  };
  using S = SmoothingKernel;
  EXPECT_NEAR(at_zero(S::kSpiky, 3), 15.0 / (kPi * std::pow(h, 6)) * std::pow(h, 3), 1e-12);
  EXPECT_NEAR(at_zero(S::kSpiky, 2), 10.0 / (kPi * std::pow(h, 5)) * std::pow(h, 3), 1e-12);
  EXPECT_NEAR(at_zero(S::kSpiky, 1), 2.0 / std::pow(h, 4) * std::pow(h, 3), 1e-12);
  EXPECT_NEAR(at_zero(S::kPoly6, 3), 315.0 / (64.0 * kPi * std::pow(h, 9)) * std::pow(h, 6), 1e-12);
  EXPECT_NEAR(at_zero(S::kPoly6, 2), 4.0 / (kPi * std::pow(h, 8)) * std::pow(h, 6), 1e-12);
  EXPECT_NEAR(at_zero(S::kPoly6, 1), 35.0 / (32.0 * std::pow(h, 7)) * std::pow(h, 6), 1e-12);
}

TEST(SmoothingKernel, WithoutItsNormSpikyIsNoKernel) {  // as the notes print it
  const double h = 0.8;
  const double sum = integral([&](double r) { return surface(3, r) * std::pow(h - r, 3); }, 0.0, h, 32);
  EXPECT_GT(std::abs(sum - 1.0), 0.5);  // 0.055
}

TEST(SmoothingKernel, ViscosityIsRefusedOnALineAndForDensities) {
  EXPECT_FALSE(is_defined(SmoothingKernel::kViscosity, 1));
  EXPECT_FALSE(smooths_density(SmoothingKernel::kViscosity));
  EXPECT_THROW((void)kernel_value(SmoothingKernel::kViscosity, 1, 1.0, 0.5), MisuseError);
}

}  // namespace
}  // namespace feder
