// Threads and versions of the numerical libraries. The BLAS is exchangeable at run time on Debian, so
// OpenBLAS is not linked by name: its functions are looked up in the running process.
#include "solvers/threads.h"

#include <cholmod.h>
#include <dlfcn.h>
#include <omp.h>
#include <sundials/sundials_version.h>
#include <unistd.h>

#include <Eigen/Core>
#include <array>
#include <cstdlib>

#include "engine/check.h"

namespace feder {
namespace {

// A function of the running process, null if no loaded library has it.
template <class Function>
Function* find_function(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

std::string dotted(int major, int minor, int patch) {
  return std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(patch);
}

}  // namespace

void set_threads(int threads) {
  FEDER_CHECK(threads >= 1, "the number of threads must be at least 1");
  // 0 active levels: every parallel region runs on its caller, whatever number of threads it asks for
  omp_set_max_active_levels(threads == 1 ? 0 : 1);
  omp_set_num_threads(threads);
  if (auto* set_blas_threads = find_function<void(int)>("openblas_set_num_threads")) set_blas_threads(1);
}

std::string blas_name() {
  auto* config = find_function<char*()>("openblas_get_config");
  return config ? std::string(config()) : "reference or unknown BLAS";
}

std::string better_blas_core() {
#if defined(__x86_64__)
  auto* core = find_function<char*()>("openblas_get_corename");
  if (!core) return {};
  const std::string name = core();
  const bool oldest = name == "Prescott" || name == "Core2" || name == "Generic" || name == "generic";
  __builtin_cpu_init();
  if (oldest && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) return "SKYLAKEX";
  if (oldest && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return "HASWELL";
#endif
  return {};
}

void restart_with_better_blas(char** argv) {
  const std::string core = better_blas_core();
  if (core.empty() || std::getenv("OPENBLAS_CORETYPE")) return;
  setenv("OPENBLAS_CORETYPE", core.c_str(), 1);
  execv("/proc/self/exe", argv);  // returns only where it failed: then the slow kernels run
}

std::map<std::string, std::string> library_versions() {
  std::array<int, 3> suitesparse{}, cholmod{};
  SuiteSparse_version(suitesparse.data());
  cholmod_version(cholmod.data());
  std::array<char, 64> sundials{};
  if (SUNDIALSGetVersion(sundials.data(), static_cast<int>(sundials.size())) != 0) sundials[0] = '\0';
  return {{"Eigen", dotted(EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
          {"SuiteSparse", dotted(suitesparse[0], suitesparse[1], suitesparse[2])},
          {"CHOLMOD", dotted(cholmod[0], cholmod[1], cholmod[2])},
          {"SUNDIALS", sundials.data()},
          {"BLAS", blas_name()}};
}

}  // namespace feder
