// 4 rows at a time. Compiled with -mavx2; called only after the processor was asked.
#include <immintrin.h>

#include "engine/kernels.h"

namespace {
constexpr int kLanes = 4;
inline __m256d vector_sqrt(__m256d x) {
  return _mm256_sqrt_pd(x);
}
}  // namespace

#include "engine/kernels_vector.h"

namespace feder {
namespace {

// x0 y0 z0 x1 | y1 z1 x2 y2 | z2 x3 y3 z3
inline Vec sum_by_threes(const Triple& t) {
  const Vec p = t.part[0], q = t.part[1], r = t.part[2];
  const Vec xy = __builtin_shufflevector(p, q, 0, 3, 6, 1), zz = __builtin_shufflevector(q, r, 1, 4, 2, 3);
  const Vec x = __builtin_shufflevector(xy, r, 0, 1, 2, 5);
  const Vec y = __builtin_shufflevector(__builtin_shufflevector(p, q, 1, 4, 7, 0), r, 0, 1, 2, 6);
  const Vec z = __builtin_shufflevector(__builtin_shufflevector(p, zz, 2, 4, 5, 0), r, 0, 1, 2, 7);
  return x + y + z;
}

inline Triple spread_by_threes(Vec x) {
  return {{__builtin_shufflevector(x, x, 0, 0, 0, 1), __builtin_shufflevector(x, x, 1, 1, 2, 2),
           __builtin_shufflevector(x, x, 2, 3, 3, 3)}};
}

inline Vec later_by_three(Vec x, Vec y) {
  return __builtin_shufflevector(x, y, 1, 2, 3, 4);
}

}  // namespace

const Kernels& avx2_kernels() {
  static const Kernels kernels{
      "avx2",        plain_forces, damped_forces, evaluate, multiply, multiply_weighted,
      add_transpose, momentum,     product,       drift,    kick,     balance};
  return kernels;
}

}  // namespace feder
