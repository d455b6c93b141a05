// Smoothing kernels W(r) = c f(r/h) / h^D with support h, normalised: the integral over D dimensions is 1
// (notes G2, G3; Mueller, Charypar, Gross, SCA 2003; Dehnen and Aly, MNRAS 425, 2012). f of x = r/h < 1:
//   spiky          (1-x)^3
//   poly6          (1-x^2)^3
//   poly6 printed  1-x^3, whose slope -3 at x = 1 is a jump of the force
//   viscosity      -x^3/2 + x^2 + 1/(2x) - 1, infinite at 0: not for densities
//   cubic spline   1 - 6x^2 + 6x^3 up to x = 1/2, then 2 (1-x)^3
//   Wendland C2    (1-x)^4 (1+4x), on a line (1-x)^3 (1+3x)
//   Wendland C4    (1-x)^6 (1+6x+35/3 x^2), on a line (1-x)^5 (1+5x+8x^2)
#pragma once

#include <numbers>
#include <string>

namespace feder {

enum class SmoothingKernel {
  kSpiky,
  kPoly6,
  kPoly6Printed,
  kViscosity,
  kCubicSpline,
  kWendland2,
  kWendland4
};
inline constexpr SmoothingKernel kSmoothingKernels[] = {
    SmoothingKernel::kSpiky,     SmoothingKernel::kPoly6,       SmoothingKernel::kPoly6Printed,
    SmoothingKernel::kViscosity, SmoothingKernel::kCubicSpline, SmoothingKernel::kWendland2,
    SmoothingKernel::kWendland4};

/// "spiky", "poly6", "poly6_printed", "viscosity", "cubic_spline", "wendland2", "wendland4".
const char* to_string(SmoothingKernel kernel);
/// False for the viscosity kernel on a line, where it has no integral.
bool is_defined(SmoothingKernel kernel, int dimension);
/// False where W(0) is infinite.
bool smooths_density(SmoothingKernel kernel);
/// W(r) [1/m^D] and dW/dr [1/m^(D+1)]; 0 from r = support on. MisuseError where the kernel is not defined.
double kernel_value(SmoothingKernel kernel, int dimension, double support, double r);
double kernel_slope(SmoothingKernel kernel, int dimension, double support, double r);

/// c, f and df/dx of one kernel in D dimensions, for inner loops; 0 <= x < 1.
template <SmoothingKernel K, int D>
struct KernelShape {
  static constexpr double kPi = std::numbers::pi;
  /// One of three by dimension.
  static constexpr double pick(double line, double plane, double space) {
    return D == 1 ? line : D == 2 ? plane : space;
  }

  static constexpr double norm() {
    switch (K) {
      case SmoothingKernel::kSpiky:
        return pick(2.0, 10.0 / kPi, 15.0 / kPi);
      case SmoothingKernel::kPoly6:
        return pick(35.0 / 32.0, 4.0 / kPi, 315.0 / (64.0 * kPi));
      case SmoothingKernel::kPoly6Printed:
        return pick(2.0 / 3.0, 5.0 / (3.0 * kPi), 3.0 / (2.0 * kPi));
      case SmoothingKernel::kViscosity:
        return pick(0.0, 10.0 / (3.0 * kPi), 15.0 / (2.0 * kPi));
      case SmoothingKernel::kCubicSpline:
        return pick(4.0 / 3.0, 40.0 / (7.0 * kPi), 8.0 / kPi);
      case SmoothingKernel::kWendland2:
        return pick(5.0 / 4.0, 7.0 / kPi, 21.0 / (2.0 * kPi));
      case SmoothingKernel::kWendland4:
        return pick(3.0 / 2.0, 9.0 / kPi, 495.0 / (32.0 * kPi));
    }
  }

  static constexpr double value(double x) {
    const double y = 1.0 - x;
    switch (K) {
      case SmoothingKernel::kSpiky:
        return y * y * y;
      case SmoothingKernel::kPoly6:
        return (1.0 - x * x) * (1.0 - x * x) * (1.0 - x * x);
      case SmoothingKernel::kPoly6Printed:
        return 1.0 - x * x * x;
      case SmoothingKernel::kViscosity:
        return x * x * (1.0 - 0.5 * x) + 0.5 / x - 1.0;
      case SmoothingKernel::kCubicSpline:
        return x < 0.5 ? 1.0 - 6.0 * x * x * y : 2.0 * y * y * y;
      case SmoothingKernel::kWendland2:
        return D == 1 ? y * y * y * (1.0 + 3.0 * x) : y * y * y * y * (1.0 + 4.0 * x);
      case SmoothingKernel::kWendland4:
        return D == 1 ? y * y * y * y * y * (1.0 + x * (5.0 + 8.0 * x))
                      : y * y * y * y * y * y * (1.0 + x * (6.0 + 35.0 / 3.0 * x));
    }
  }

  static constexpr double slope(double x) {
    const double y = 1.0 - x;
    switch (K) {
      case SmoothingKernel::kSpiky:
        return -3.0 * y * y;
      case SmoothingKernel::kPoly6:
        return -6.0 * x * (1.0 - x * x) * (1.0 - x * x);
      case SmoothingKernel::kPoly6Printed:
        return -3.0 * x * x;
      case SmoothingKernel::kViscosity:
        return x * (2.0 - 1.5 * x) - 0.5 / (x * x);
      case SmoothingKernel::kCubicSpline:
        return x < 0.5 ? x * (18.0 * x - 12.0) : -6.0 * y * y;
      case SmoothingKernel::kWendland2:
        return (D == 1 ? -12.0 * x * y * y : -20.0 * x * y * y * y);
      case SmoothingKernel::kWendland4:
        return D == 1 ? -14.0 * x * y * y * y * y * (1.0 + 4.0 * x)
                      : -56.0 / 3.0 * x * y * y * y * y * y * (1.0 + 5.0 * x);
    }
  }
};

/// Calls visit.template operator()<K, D>().
template <SmoothingKernel K, class Visit>
void with_dimension(int dimension, Visit&& visit) {
  if (dimension == 1)
    visit.template operator()<K, 1>();
  else if (dimension == 2)
    visit.template operator()<K, 2>();
  else
    visit.template operator()<K, 3>();
}
template <class Visit>
void with_kernel(SmoothingKernel kernel, int dimension, Visit&& visit) {
  using S = SmoothingKernel;
  switch (kernel) {
    case S::kSpiky:
      return with_dimension<S::kSpiky>(dimension, visit);
    case S::kPoly6:
      return with_dimension<S::kPoly6>(dimension, visit);
    case S::kPoly6Printed:
      return with_dimension<S::kPoly6Printed>(dimension, visit);
    case S::kViscosity:
      return with_dimension<S::kViscosity>(dimension, visit);
    case S::kCubicSpline:
      return with_dimension<S::kCubicSpline>(dimension, visit);
    case S::kWendland2:
      return with_dimension<S::kWendland2>(dimension, visit);
    case S::kWendland4:
      return with_dimension<S::kWendland4>(dimension, visit);
  }
}

}  // namespace feder
