#pragma once

#include <map>
#include <string>

namespace feder {

/// Sets the number of threads (>= 1) of OpenMP; the BLAS keeps to one, for its threads split sums: with them
/// results would depend on their number, while CHOLMOD's own loops split columns. With one thread OpenMP
/// regions inside libraries are switched off altogether: CHOLMOD asks for 4 threads whatever the machine.
/// Call it once, before the first solve.
void set_threads(int threads);

/// Name, version and threading of the BLAS that runs, "reference or unknown BLAS" if it is not OpenBLAS.
std::string blas_name();

/// The OPENBLAS_CORETYPE under which OpenBLAS would use this processor's vector units, empty if it does
/// already. An OpenBLAS older than the processor falls back to its oldest kernels (measured: 2.5 times slower
/// factorisations).
std::string better_blas_core();

/// Restarts this program with that core type in its environment: OpenBLAS reads it only when it is loaded.
/// Does nothing if there is none better or the user has set OPENBLAS_CORETYPE. Call it first thing in main.
void restart_with_better_blas(char** argv);

/// Versions of what actually runs: "Eigen", "SuiteSparse", "CHOLMOD", "SUNDIALS", "BLAS". Goes into
/// manifests.
std::map<std::string, std::string> library_versions();

}  // namespace feder
