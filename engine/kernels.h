#pragma once

#include <cstddef>

namespace feder {

/// Lanes of a batch: distance rows are stored in groups of this many, whatever the vector width of the
/// machine.
inline constexpr int kBatch = 8;

/// Raw view of the distance rows: no Eigen type crosses this border (design.md section 8).
struct DistanceView {
  const int* a;
  const int* b;
  const int* run;
  const double* rest;
  const double* spring;
  const double* damping;
  int batches;
};

/// The operations worth wide instructions, behind raw pointers. On distance rows u points from a to b; J v =
/// u.(v_b - v_a). `forces` and `evaluate` return the least squared length met [m^2] (0: coincident points,
/// NaN: a bad state).
struct Kernels {
  const char* name;
  /// f += J^T lambda with lambda = -spring phi.
  double (*forces)(const DistanceView&, const double* q, double* f);
  /// The same with lambda = -spring phi - damping J v.
  double (*damped_forces)(const DistanceView&, const double* q, const double* v, double* f);
  /// u: 3 per row; length: 1 per row [m], may be null; phi: 1 per row [m].
  double (*evaluate)(const DistanceView&, const double* q, double* u, double* length, double* phi);
  /// out[k] = u_k.(v_b - v_a).
  void (*multiply)(const DistanceView&, const double* u, const double* v, double* out);
  /// out[k] = u_k.(w_b x_b - w_a x_a), w elementwise: J W x for a diagonal W.
  void (*multiply_weighted)(const DistanceView&, const double* u, const double* w, const double* x,
                            double* out);
  /// f += J^T y.
  void (*add_transpose)(const DistanceView&, const double* u, const double* y, double* f);

  /// out = m * v + a f with one m per three numbers; n numbers.
  void (*momentum)(std::size_t n, const double* m, const double* v, double a, const double* f, double* out);
  /// out = x * y, elementwise (out may be x or y).
  void (*product)(std::size_t n, const double* x, const double* y, double* out);
  /// out = x + a v (out may be x).
  void (*drift)(std::size_t n, double a, const double* v, const double* x, double* out);
  /// out = v + a w * f (out may be v).
  void (*kick)(std::size_t n, double a, const double* w, const double* f, const double* v, double* out);
  /// out = a + s x * y + z (not stored if out is null), and the squared norms of a, x * y, z, out and y in
  /// sums[0..4].
  void (*balance)(std::size_t n, const double* a, double s, const double* x, const double* y, const double* z,
                  double* out, double* sums);
};

/// The plain loop, one row after the other: the reference for the others.
const Kernels& scalar_kernels();
const Kernels& avx2_kernels();
const Kernels& avx512_kernels();

/// The widest kernels this processor runs; `select_kernels` overrides it by name ("scalar", "avx2", "avx512")
/// for comparisons and returns false if the processor does not have them.
const Kernels& kernels();
bool select_kernels(const char* name);

}  // namespace feder
