// Two at a time: what every x86-64 has, and plain enough for any other machine.
#include <cstring>

#include "engine/kernels.h"
#include "solvers/linear/block_kernels.h"

namespace {
constexpr int kLanes = 2;
}  // namespace

#include "solvers/linear/block_kernels_vector.h"

namespace feder {
namespace {

inline void subtract_first(double* p, Vec x, int count) {
  for (int i = 0; i < count; ++i) p[i] -= x[i];
}
inline void subtract_three(double* p, const double* x) {
  for (int i = 0; i < 3; ++i) p[i] -= x[i];
}
inline Bits lane_numbers() {
  return Bits{0, 1};
}

}  // namespace

const BlockKernels& scalar_block_kernels() {
  static const BlockKernels kernels{"scalar", update, eliminate, forward, backward};
  return kernels;
}

const BlockKernels& block_kernels() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (std::strcmp(kernels().name, "scalar") != 0 && __builtin_cpu_supports("fma"))
    return avx2_block_kernels();
#endif
  return scalar_block_kernels();
}

}  // namespace feder
