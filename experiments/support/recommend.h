#pragma once

#include "experiments/support/explain.h"

namespace feder::experiments {

/// By the rules at the top of recommend.cpp, from the figures of `known` (all but `recommended` are read) and
/// the kinds of force in the system.
Recommendation recommend(const Explanation& known, const System& system);

}  // namespace feder::experiments
