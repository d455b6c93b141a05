#include "experiments/support/build_info.h"

// Both are generated in the build tree.
#include "feder_build_flags.h"
#include "feder_git_info.h"

namespace feder::experiments {

BuildInfo build_info() {
  return {FEDER_VERSION,  FEDER_GIT_COMMIT,     FEDER_GIT_DIRTY,
          FEDER_COMPILER, FEDER_COMPILER_FLAGS, FEDER_BUILD_TYPE};
}

}  // namespace feder::experiments
