#pragma once

#include <string>

namespace feder::experiments {

/// What the program was built from and with. The commit is looked up on every build; "unknown" outside git.
struct BuildInfo {
  std::string version;
  std::string commit;
  std::string dirty;  ///< "yes", "no" or "unknown": tracked files differ from the commit
  std::string compiler;
  std::string flags;
  std::string build_type;
};

BuildInfo build_info();

}  // namespace feder::experiments
