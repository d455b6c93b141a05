#pragma once

#include <string>
#include <vector>

#include "engine/system.h"

namespace feder {

/// Inertia of the KKT matrix; a sound one is (n, m, 0).
struct Inertia {
  int positive = 0, negative = 0, zero = 0;
};

/// Numbering of the free coordinates by an order of their nodes: coordinate of each unknown, and unknown of
/// each coordinate
/// (-1 if masked).
struct Numbering {
  std::vector<int> coordinate, unknown;
  std::string ordering;
};
Numbering number_free_coordinates(const System& system);

}  // namespace feder
