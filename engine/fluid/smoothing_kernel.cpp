#include "engine/fluid/smoothing_kernel.h"

#include <cmath>

#include "engine/check.h"

namespace feder {

const char* to_string(SmoothingKernel kernel) {
  switch (kernel) {
    case SmoothingKernel::kSpiky:
      return "spiky";
    case SmoothingKernel::kPoly6:
      return "poly6";
    case SmoothingKernel::kPoly6Printed:
      return "poly6_printed";
    case SmoothingKernel::kViscosity:
      return "viscosity";
    case SmoothingKernel::kCubicSpline:
      return "cubic_spline";
    case SmoothingKernel::kWendland2:
      return "wendland2";
    case SmoothingKernel::kWendland4:
      return "wendland4";
  }
  return "";
}

bool is_defined(SmoothingKernel kernel, int dimension) {
  return dimension >= 1 && dimension <= 3 && (kernel != SmoothingKernel::kViscosity || dimension > 1);
}

bool smooths_density(SmoothingKernel kernel) {
  return kernel != SmoothingKernel::kViscosity;
}

double kernel_value(SmoothingKernel kernel, int dimension, double support, double r) {
  FEDER_CHECK(is_defined(kernel, dimension), "smoothing kernel: not defined in this dimension");
  double value = 0.0;
  if (r < support)
    with_kernel(kernel, dimension, [&]<SmoothingKernel K, int D>() {
      value = KernelShape<K, D>::norm() * KernelShape<K, D>::value(r / support) / std::pow(support, D);
    });
  return value;
}

double kernel_slope(SmoothingKernel kernel, int dimension, double support, double r) {
  FEDER_CHECK(is_defined(kernel, dimension), "smoothing kernel: not defined in this dimension");
  double slope = 0.0;
  if (r < support)
    with_kernel(kernel, dimension, [&]<SmoothingKernel K, int D>() {
      slope = KernelShape<K, D>::norm() * KernelShape<K, D>::slope(r / support) / std::pow(support, D + 1);
    });
  return slope;
}

}  // namespace feder
