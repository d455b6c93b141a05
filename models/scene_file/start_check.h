#pragma once

#include <vector>

#include "engine/system.h"

namespace feder {

/// A hard row that the start of a scene does not fit.
struct Misfit {
  int row = 0;        ///< into phi
  double size = 0.0;  ///< |phi| [m], [rad] or [1]; or |J v + phi_t| per second
};

/// Hard rows that are open at the start by more than 1e-6 m or rad, or 1e-6 of the place farthest from the
/// origin.
std::vector<Misfit> open_rows(const System& system, const State& start);

/// Hard rows whose rate at the start is more than 1e-6 of the fastest velocity in the scene: the first step
/// takes that motion away, and its energy with it.
std::vector<Misfit> moving_rows(const System& system, const State& start);

}  // namespace feder
