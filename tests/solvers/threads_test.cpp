#include "solvers/threads.h"

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <omp.h>

#include "engine/check.h"

namespace feder {
namespace {

int threads_of_a_region_that_asks_for_four() {
  int threads = 0;
#pragma omp parallel num_threads(4)
  {
#pragma omp single
    threads = omp_get_num_threads();
  }
  return threads;
}

TEST(Threads, OneThreadSilencesRegionsThatAskForMore) {
  set_threads(4);
  ASSERT_GT(threads_of_a_region_that_asks_for_four(), 1);  // 4: the request is honoured otherwise
  set_threads(1);
  EXPECT_EQ(threads_of_a_region_that_asks_for_four(), 1);
}

TEST(Threads, AskingForSeveralSetsTheDefaultTeam) {
  set_threads(2);
  EXPECT_EQ(omp_get_max_threads(), 2);
  set_threads(1);
  EXPECT_EQ(omp_get_max_threads(), 1);
}

TEST(Threads, BlasKeepsToOneWhateverTheirNumber) {
  auto* blas_threads = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "openblas_get_num_threads"));
  if (!blas_threads) GTEST_SKIP() << blas_name() << " has no threads to ask for";
  set_threads(2);
  EXPECT_EQ(blas_threads(), 1);
  set_threads(1);
  EXPECT_EQ(blas_threads(), 1);
}

TEST(Threads, NumberBelowOneIsMisuse) {
  EXPECT_THROW(set_threads(0), MisuseError);
  EXPECT_THROW(set_threads(-3), MisuseError);
}

TEST(LibraryVersions, NameEveryNumericalLibrary) {
  const auto versions = library_versions();
  for (const char* name : {"Eigen", "SuiteSparse", "CHOLMOD", "SUNDIALS", "BLAS"}) {
    ASSERT_TRUE(versions.contains(name)) << name;
    EXPECT_FALSE(versions.at(name).empty()) << name;
  }
  EXPECT_EQ(versions.at("Eigen").substr(0, 2), "3.");
  EXPECT_EQ(versions.at("SUNDIALS")[0], '6');  // "6.4.1"
  EXPECT_EQ(versions.at("BLAS"), blas_name());
}

}  // namespace
}  // namespace feder
