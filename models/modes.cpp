// Normal modes of n equal masses between two fixed ends, tied by n + 1 equal springs: the matrix tridiag(-1,
// 2, -1) has eigenvectors sin(i j pi / (n + 1)) and eigenvalues 4 sin^2(j pi / (2 (n + 1))).
#include "models/modes.h"

#include <cmath>
#include <numbers>
#include <string>

#include "engine/check.h"

namespace feder {

int mode_index(const char* place, const Mode& mode, int n) {
  const int j = mode.number > 0 ? mode.number : n + 1 + mode.number;
  if (mode.number == 0 || j < 1 || j > n)
    fail_input(
        place, "mode number", mode.number, "",
        "1 to " + std::to_string(n) + ", or -1 to -" + std::to_string(n) + " counted from the highest");
  return j;
}

double mode_shape(int n, int j, int i) {
  return std::sin(i * (j * std::numbers::pi / (n + 1)));
}

double mode_frequency(int n, int j, double stiffness, double mass) {
  return 2.0 * std::sqrt(stiffness / mass) * std::sin(j * std::numbers::pi / (2.0 * (n + 1)));
}

}  // namespace feder
