#pragma once

#include <vector>

#include "engine/kkt.h"

namespace feder {

/// Rank of the hard rows of a linearisation: SPQR on J^T with every row of J scaled to length 1; a row counts
/// as dependent where less than `tolerance` of it is new.
struct RowRank {
  int hard_rows = 0, rank = 0;
  std::vector<int> dependent;  ///< rows whose removal leaves the others independent, of the same rank
};
RowRank hard_row_rank(const Kkt& kkt, double tolerance = 1e-8);

/// J_k M^-1 J_k^T of every row [1/kg]: how far a unit impulse of the row alone moves it. The largest one
/// where it is 0 (rows between points that cannot move).
VectorXd row_mobility(const Kkt& kkt);

/// Of all multipliers of the hard rows with the force J^T y at q, those with the least sum of y_k^2 J_k M^-1
/// J_k^T: the impulses of the rows one by one, in the metric of M^-1. About 6 digits where rows are
/// redundant.
VectorXd least_norm_multipliers(const System& system, const VectorXd& q, const VectorXd& y);

}  // namespace feder
