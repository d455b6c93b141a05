#pragma once

#include <variant>

#include "solvers/linear/dense_reference.h"
#include "solvers/linear/dual_blocks.h"
#include "solvers/linear/dual_schur.h"
#include "solvers/linear/kkt_ldlt.h"
#include "solvers/linear/primal_schur.h"

namespace feder {

/// THE LIST of routes through the one matrix. A route has kName, refusal(), analyze(), assemble(), factor(),
/// the three parts of a solve (reduce to its own unknowns, substitute through the factor, expand to v and y),
/// flops(), description(), rcond() and inertia(); adding one is its file pair and its name here.
using Route = std::variant<KktLdlt, PrimalSchur, DualSchur, DualBlocks, DenseReference>;

}  // namespace feder
