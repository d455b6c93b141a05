// 8 rows at a time. Compiled with -mavx512f -mavx512dq; called only after the processor was asked.
#include <immintrin.h>

#include "engine/kernels.h"

namespace {
constexpr int kLanes = 8;
inline __m512d vector_sqrt(__m512d x) {
  return _mm512_sqrt_pd(x);
}
}  // namespace

#include "engine/kernels_vector.h"

namespace feder {
namespace {

// x0 y0 z0 x1 y1 z1 x2 y2 | z2 x3 y3 z3 x4 y4 z4 x5 | y5 z5 x6 y6 z6 x7 y7 z7
inline Vec sum_by_threes(const Triple& t) {
  const Vec p = t.part[0], q = t.part[1], r = t.part[2];
  const Vec x = __builtin_shufflevector(__builtin_shufflevector(p, q, 0, 3, 6, 9, 12, 15, 0, 0), r, 0, 1, 2,
                                        3, 4, 5, 10, 13);
  const Vec y = __builtin_shufflevector(__builtin_shufflevector(p, q, 1, 4, 7, 10, 13, 0, 0, 0), r, 0, 1, 2,
                                        3, 4, 8, 11, 14);
  const Vec z = __builtin_shufflevector(__builtin_shufflevector(p, q, 2, 5, 8, 11, 14, 0, 0, 0), r, 0, 1, 2,
                                        3, 4, 9, 12, 15);
  return x + y + z;
}

inline Triple spread_by_threes(Vec x) {
  return {{__builtin_shufflevector(x, x, 0, 0, 0, 1, 1, 1, 2, 2),
           __builtin_shufflevector(x, x, 2, 3, 3, 3, 4, 4, 4, 5),
           __builtin_shufflevector(x, x, 5, 5, 6, 6, 6, 7, 7, 7)}};
}

inline Vec later_by_three(Vec x, Vec y) {
  return __builtin_shufflevector(x, y, 5, 6, 7, 8, 9, 10, 11, 12);
}

}  // namespace

const Kernels& avx512_kernels() {
  static const Kernels kernels{
      "avx512",      plain_forces, damped_forces, evaluate, multiply, multiply_weighted,
      add_transpose, momentum,     product,       drift,    kick,     balance};
  return kernels;
}

}  // namespace feder
