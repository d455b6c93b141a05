// The loops of the block Cholesky factorisation, kLanes numbers at a time. Included by one source file per
// instruction set, which defines kLanes; everything is in an unnamed namespace, because code compiled with
// wide instructions must not be merged by the linker.
#include <cstddef>

#include "solvers/linear/block_kernels.h"

namespace feder {
namespace {

typedef double Vec __attribute__((vector_size(kLanes * 8)));
typedef long long Bits __attribute__((vector_size(kLanes * 8)));

inline Vec load(const double* p) {
  Vec x;
  __builtin_memcpy(&x, p, sizeof x);
  return x;
}
inline void store(double* p, Vec x) {
  __builtin_memcpy(p, &x, sizeof x);
}
void subtract_first(double* p, Vec x, int count);  // p[i] -= x[i], i < count < kLanes
void subtract_three(double* p, const double* x);   // the same for three numbers in memory
Bits lane_numbers();

// sum[v][c] = sum over k of X(rows of v, k) Y(c, k)
template <int kVectors>
inline void product(const double* x, const double* y, int stride, int depth, Vec (&sum)[kVectors][3]) {
  for (int v = 0; v < kVectors; ++v) sum[v][0] = sum[v][1] = sum[v][2] = Vec{};
  for (int k = 0; k < depth; ++k, x += stride, y += stride)
    for (int v = 0; v < kVectors; ++v) {
      const Vec xv = load(x + v * kLanes);
      for (int c = 0; c < 3; ++c) sum[v][c] += xv * y[c];
    }
}

// one tile of `update`: `blocks` block rows, at most kLanes, in kVectors vectors
template <int kVectors>
void update_tile(const double* x, const double* y, int stride, int depth, int blocks, const int* relative,
                 double* target, int target_stride) {
  Vec sum[kVectors][3];
  product<kVectors>(x, y, stride, depth, sum);
  if (relative[blocks - 1] - relative[0] == blocks - 1) {
    double* to = target + 3 * relative[0];
    for (int c = 0; c < 3; ++c, to += target_stride) {
      for (int v = 0; v < kVectors - 1; ++v) store(to + v * kLanes, load(to + v * kLanes) - sum[v][c]);
      subtract_first(to + (kVectors - 1) * kLanes, sum[kVectors - 1][c],
                     3 * blocks - (kVectors - 1) * kLanes);
    }
    return;
  }
  alignas(64) double buffer[3][kVectors * kLanes + 4];
  for (int c = 0; c < 3; ++c)
    for (int v = 0; v < kVectors; ++v) store(buffer[c] + v * kLanes, sum[v][c]);
  for (int i = 0; i < blocks; ++i)
    for (int c = 0; c < 3; ++c)
      subtract_three(target + 3 * relative[i] + c * target_stride, buffer[c] + 3 * i);
}

void update(const double* source, int stride, int depth, int rows, int columns, const int* relative,
            double* target, int target_stride) {
  for (int j = 0; j < columns; ++j) {
    const double* y = source + 3 * j;
    double* to = target + 3L * relative[j] * target_stride;
    for (int i = j; i < rows; i += kLanes) {
      const double* x = source + 3 * i;
      const int blocks = rows - i < kLanes ? rows - i : kLanes, vectors = (3 * blocks + kLanes - 1) / kLanes;
      if (vectors == 1)
        update_tile<1>(x, y, stride, depth, blocks, relative + i, to, target_stride);
      else if (vectors == 2)
        update_tile<2>(x, y, stride, depth, blocks, relative + i, to, target_stride);
      else
        update_tile<3>(x, y, stride, depth, blocks, relative + i, to, target_stride);
    }
  }
}

// The diagonal block at `a`: 1 / L_kk on its diagonal, L below. False at a bad pivot.
inline bool factor_diagonal(double* a, int stride, const double* original, int column, PivotWatch& watch) {
  double *b = a + stride, *c = b + stride;
  const double lower[6] = {a[0], a[1], a[2], b[1], b[2], c[2]};
  const Pivots<double> p = pivots(lower);
  const double pivot[3] = {a[0], p.pivot2, p.pivot3};
  if (!accept(watch, pivot, original, column)) return false;
  const double s1 = __builtin_sqrt(p.r1), s2 = __builtin_sqrt(a[0] * p.q2),
               s3 = __builtin_sqrt(a[0] * p.c22 * p.q3);
  c[2] = s3;
  b[1] = s2;
  b[2] = p.c32 * p.r1 * s2;
  a[1] *= s1;
  a[2] *= s1;
  a[0] = s1;
  return true;
}

template <int kVectors>
inline void subtract_tile(const double* x, const double* y, int stride, int depth, double* to) {
  Vec sum[kVectors][3];
  product<kVectors>(x, y, stride, depth, sum);
  for (int c = 0; c < 3; ++c)
    for (int v = 0; v < kVectors; ++v) {
      double* at = to + c * stride + v * kLanes;
      store(at, load(at) - sum[v][c]);
    }
}

// Rows from the aligned row `top` on: what stands above the diagonal there is never read for a result.
bool eliminate(const PanelView& panel, const double* original, int first, PivotWatch& watch) {
  const int stride = panel.stride;
  for (int c = 0; c < panel.columns; c += 3) {
    const int top = c / kLanes * kLanes;
    double* column = panel.at + static_cast<std::ptrdiff_t>(c) * stride;
    if (c > 0) {
      int i = top;
      for (; i + 4 * kLanes <= stride; i += 4 * kLanes)
        subtract_tile<4>(panel.at + i, panel.at + c, stride, c, column + i);
      const int left = (stride - i) / kLanes;
      if (left == 3) subtract_tile<3>(panel.at + i, panel.at + c, stride, c, column + i);
      if (left == 2) subtract_tile<2>(panel.at + i, panel.at + c, stride, c, column + i);
      if (left == 1) subtract_tile<1>(panel.at + i, panel.at + c, stride, c, column + i);
    }
    if (!factor_diagonal(column + c, stride, original + c, first + c, watch)) return false;
    double kept[3][3];
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i) kept[k][i] = column[c + i + k * stride];
    const double s1 = kept[0][0], s2 = kept[1][1], s3 = kept[2][2], l21 = kept[0][1], l31 = kept[0][2],
                 l32 = kept[1][2];
    for (int i = top; i < stride; i += kLanes) {
      double* at = column + i;
      const Vec x1 = load(at) * s1, x2 = (load(at + stride) - x1 * l21) * s2,
                x3 = (load(at + 2 * stride) - x1 * l31 - x2 * l32) * s3;
      store(at, x1), store(at + stride, x2), store(at + 2 * stride, x3);
    }
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i) column[c + i + k * stride] = kept[k][i];
  }
  return true;
}

void forward(const PanelView& panel, double* x) {
  const int stride = panel.stride;
  for (int c = 0; c < panel.columns; c += 3) {
    const double* a = panel.at + static_cast<std::ptrdiff_t>(c) * stride;
    const double *b = a + stride, *d = b + stride;
    const double y1 = x[c] * a[c], y2 = (x[c + 1] - a[c + 1] * y1) * b[c + 1],
                 y3 = (x[c + 2] - a[c + 2] * y1 - b[c + 2] * y2) * d[c + 2];
    x[c] = y1, x[c + 1] = y2, x[c + 2] = y3;
    for (int i = c + 3; i < panel.rows; i += kLanes)
      store(x + i, load(x + i) - (load(a + i) * y1 + load(b + i) * y2 + load(d + i) * y3));
  }
}

inline Vec keep(Bits condition, Vec x) {
  return reinterpret_cast<Vec>(condition & reinterpret_cast<Bits>(x));
}
inline double sum_of_lanes(Vec x) {
  double sum = x[0];
  for (int i = 1; i < kLanes; ++i) sum += x[i];
  return sum;
}

// x is zero from `rows` to `stride`
void backward(const PanelView& panel, double* x) {
  const int stride = panel.stride;
  for (int c = panel.columns - 3; c >= 0; c -= 3) {
    const double* a = panel.at + static_cast<std::ptrdiff_t>(c) * stride;
    const double *b = a + stride, *d = b + stride;
    Vec s1{}, s2{}, s3{};
    int i = (c + 3) / kLanes * kLanes;
    if (i < stride) {
      const Bits below = lane_numbers() + i >= c + 3;
      const Vec y = keep(below, load(x + i));
      s1 = keep(below, load(a + i)) * y, s2 = keep(below, load(b + i)) * y, s3 = keep(below, load(d + i)) * y;
    }
    for (i += kLanes; i < stride; i += kLanes) {
      const Vec y = load(x + i);
      s1 += load(a + i) * y, s2 += load(b + i) * y, s3 += load(d + i) * y;
    }
    const double x3 = (x[c + 2] - sum_of_lanes(s3)) * d[c + 2],
                 x2 = (x[c + 1] - sum_of_lanes(s2) - b[c + 2] * x3) * b[c + 1];
    x[c] = (x[c] - sum_of_lanes(s1) - a[c + 1] * x2 - a[c + 2] * x3) * a[c];
    x[c + 1] = x2, x[c + 2] = x3;
  }
}

}  // namespace
}  // namespace feder
