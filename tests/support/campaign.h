#pragma once

#include <algorithm>
#include <cstdlib>
#include <string>

namespace feder::test {

/// Cases a campaign looks at: all `full` of them where FEDER_CAMPAIGN is set (ctest label "campaign"),
/// otherwise the first 1 %.
inline int campaign_cases(int full) {
  return std::getenv("FEDER_CAMPAIGN") ? full : std::max(1, full / 100);
}

}  // namespace feder::test
