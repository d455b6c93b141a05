// Four at a time. Compiled with -mavx2 -mfma; called only after the processor was asked.
#include <immintrin.h>

namespace {
constexpr int kLanes = 4;
}  // namespace

#include "solvers/linear/block_kernels_vector.h"

namespace feder {
namespace {

inline void subtract_first(double* p, Vec x, int count) {
  const __m256i mask = reinterpret_cast<__m256i>(lane_numbers() < count);
  _mm256_maskstore_pd(p, mask, _mm256_maskload_pd(p, mask) - x);
}
// Writes the fourth number back as it was.
inline void subtract_three(double* p, const double* x) {
  const Vec zero{};
  store(p, load(p) - _mm256_blend_pd(load(x), zero, 8));
}
inline Bits lane_numbers() {
  return Bits{0, 1, 2, 3};
}

}  // namespace

const BlockKernels& avx2_block_kernels() {
  static const BlockKernels kernels{"avx2", update, eliminate, forward, backward};
  return kernels;
}

}  // namespace feder
