#pragma once

#include <map>
#include <string>

namespace feder {

/// Sets the number of threads (>= 1) of OpenMP and of the BLAS that runs. With one thread OpenMP regions
/// inside libraries are switched off altogether: CHOLMOD asks for 4 threads whatever the machine. Call it
/// once, before the first solve.
void set_threads(int threads);

/// Name, version and threading of the BLAS that runs, "reference or unknown BLAS" if it is not OpenBLAS.
std::string blas_name();

/// Versions of what actually runs: "Eigen", "SuiteSparse", "CHOLMOD", "SUNDIALS", "BLAS". Goes into
/// manifests.
std::map<std::string, std::string> library_versions();

}  // namespace feder
