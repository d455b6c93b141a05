// Distance rows one after the other: the reference, and what the vector kernels do with batches that are no
// run. Everything is in an unnamed namespace, because code compiled with wide instructions must not be merged
// by the linker.
#pragma once

#include "engine/kernels.h"

namespace feder {
namespace {

struct Direction {
  double dx, dy, dz, squared, length, inverse;
};

inline Direction direction(const DistanceView& rows, int k, const double* q) {
  const double* xa = q + 3 * static_cast<long>(rows.a[k]);
  const double* xb = q + 3 * static_cast<long>(rows.b[k]);
  Direction d{xb[0] - xa[0], xb[1] - xa[1], xb[2] - xa[2], 0.0, 0.0, 0.0};
  d.squared = d.dx * d.dx + d.dy * d.dy + d.dz * d.dz;
  d.length = __builtin_sqrt(d.squared);
  d.inverse = d.squared > 0.0 ? 1.0 / d.length : 0.0;
  return d;
}

inline double least(double a, double b) {
  return b < a || b != b ? b : a;
}  // NaN wins

// x where finite, NaN otherwise
template <class Number>
inline Number finite_or_nan(Number x) {
  return x + (x - x);
}

// f += J^T lambda over rows [begin, end); returns the least squared length
template <bool kDamped>
double scalar_forces(const DistanceView& rows, int begin, int end, const double* q, const double* v,
                     double* f) {
  double smallest = __builtin_inf();
  for (int k = begin; k < end; ++k) {
    const Direction d = direction(rows, k, q);
    smallest = least(smallest, finite_or_nan(d.squared));
    double lambda = -rows.spring[k] * (d.length - rows.rest[k]);
    const long a = 3 * static_cast<long>(rows.a[k]), b = 3 * static_cast<long>(rows.b[k]);
    if constexpr (kDamped) {
      const double rate = d.dx * (v[b] - v[a]) + d.dy * (v[b + 1] - v[a + 1]) + d.dz * (v[b + 2] - v[a + 2]);
      lambda -= rows.damping[k] * (rate * d.inverse);
    }
    const double scale = lambda * d.inverse;
    f[a] -= scale * d.dx, f[a + 1] -= scale * d.dy, f[a + 2] -= scale * d.dz;
    f[b] += scale * d.dx, f[b + 1] += scale * d.dy, f[b + 2] += scale * d.dz;
  }
  return smallest;
}

// out = a + s x * y + z over [begin, end); adds the squared norms of a, x * y, z, out, y to sums
inline void scalar_balance(std::size_t begin, std::size_t end, const double* a, double s, const double* x,
                           const double* y, const double* z, double* out, double* sums) {
  for (std::size_t i = begin; i < end; ++i) {
    const double xy = x[i] * y[i], o = a[i] + s * xy + z[i];
    sums[0] += a[i] * a[i], sums[1] += xy * xy, sums[2] += z[i] * z[i], sums[3] += o * o,
        sums[4] += y[i] * y[i];
    if (out) out[i] = o;
  }
}

}  // namespace
}  // namespace feder
