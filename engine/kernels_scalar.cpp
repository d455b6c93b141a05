// The reference loops, and the choice of kernels at run time.
#include "engine/kernels_scalar.h"

#include <cstddef>
#include <cstring>
#include <limits>

#include "engine/kernels.h"

namespace feder {
namespace {

double plain_forces(const DistanceView& rows, const double* q, double* f) {
  return scalar_forces<false>(rows, 0, kBatch * rows.batches, q, nullptr, f);
}

double damped_forces(const DistanceView& rows, const double* q, const double* v, double* f) {
  return scalar_forces<true>(rows, 0, kBatch * rows.batches, q, v, f);
}

double evaluate(const DistanceView& rows, const double* q, double* u, double* length, double* phi) {
  double smallest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kBatch * rows.batches; ++k) {
    const Direction d = direction(rows, k, q);
    smallest = least(smallest, finite_or_nan(d.squared));
    u[3 * k] = d.dx * d.inverse, u[3 * k + 1] = d.dy * d.inverse, u[3 * k + 2] = d.dz * d.inverse;
    if (length) length[k] = d.length;
    phi[k] = d.length - rows.rest[k];
  }
  return smallest;
}

void multiply(const DistanceView& rows, const double* u, const double* v, double* out) {
  for (int k = 0; k < kBatch * rows.batches; ++k) {
    const double* va = v + 3 * static_cast<std::ptrdiff_t>(rows.a[k]);
    const double* vb = v + 3 * static_cast<std::ptrdiff_t>(rows.b[k]);
    out[k] = u[3 * k] * (vb[0] - va[0]) + u[3 * k + 1] * (vb[1] - va[1]) + u[3 * k + 2] * (vb[2] - va[2]);
  }
}

void multiply_weighted(const DistanceView& rows, const double* u, const double* w, const double* x,
                       double* out) {
  for (int k = 0; k < kBatch * rows.batches; ++k) {
    const long a = 3 * static_cast<long>(rows.a[k]), b = 3 * static_cast<long>(rows.b[k]);
    double sum = 0.0;
    for (int c = 0; c < 3; ++c) sum += u[3 * k + c] * (w[b + c] * x[b + c] - w[a + c] * x[a + c]);
    out[k] = sum;
  }
}

void add_transpose(const DistanceView& rows, const double* u, const double* y, double* f) {
  for (int k = 0; k < kBatch * rows.batches; ++k) {
    double* fa = f + 3 * static_cast<std::ptrdiff_t>(rows.a[k]);
    double* fb = f + 3 * static_cast<std::ptrdiff_t>(rows.b[k]);
    for (int c = 0; c < 3; ++c) {
      const double force = y[k] * u[3 * k + c];
      fa[c] -= force;
      fb[c] += force;
    }
  }
}

void product(std::size_t n, const double* x, const double* y, double* out) {
  for (std::size_t i = 0; i < n; ++i) out[i] = x[i] * y[i];
}

void momentum(std::size_t n, const double* m, const double* v, double a, const double* f, double* out) {
  for (std::size_t i = 0; i < n; ++i) out[i] = m[i / 3] * v[i] + a * f[i];
}

void drift(std::size_t n, double a, const double* v, const double* x, double* out) {
  for (std::size_t i = 0; i < n; ++i) out[i] = x[i] + a * v[i];
}

void kick(std::size_t n, double a, const double* w, const double* f, const double* v, double* out) {
  for (std::size_t i = 0; i < n; ++i) out[i] = v[i] + a * w[i] * f[i];
}

void balance(std::size_t n, const double* a, double s, const double* x, const double* y, const double* z,
             double* out, double* sums) {
  for (int j = 0; j < 5; ++j) sums[j] = 0.0;
  scalar_balance(0, n, a, s, x, y, z, out, sums);
}

const Kernels* widest() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) return &avx512_kernels();
  if (__builtin_cpu_supports("avx2")) return &avx2_kernels();
#endif
  return &scalar_kernels();
}

const Kernels*& selected() {
  static const Kernels* kernels = widest();
  return kernels;
}

}  // namespace

const Kernels& scalar_kernels() {
  static const Kernels kernels{
      "scalar",      plain_forces, damped_forces, evaluate, multiply, multiply_weighted,
      add_transpose, momentum,     product,       drift,    kick,     balance};
  return kernels;
}

const Kernels& kernels() {
  return *selected();
}

bool select_kernels(const char* name) {
  const bool wide = std::strcmp(name, "avx512") == 0, middle = std::strcmp(name, "avx2") == 0;
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (wide && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq"))
    return selected() = &avx512_kernels(), true;
  if (middle && __builtin_cpu_supports("avx2")) return selected() = &avx2_kernels(), true;
#endif
  if (wide || middle || std::strcmp(name, "scalar") != 0) return false;
  return selected() = &scalar_kernels(), true;
}

}  // namespace feder
