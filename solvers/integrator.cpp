#include "solvers/integrator.h"

#include <cmath>

namespace feder {

std::string refuse_hard_rows(const System& system, const char* integrator) {
  if (!system.has_hard_rows) return {};
  for (int k = 0; k < system.rows; ++k)
    if (std::isinf(system.stiffness[k]))
      return std::string(integrator) + " is explicit and takes finite stiffness only: " + system.row_name(k) +
             " is rigid";
  return {};
}

}  // namespace feder
