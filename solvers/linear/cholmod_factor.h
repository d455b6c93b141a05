#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/state.h"
#include "engine/status.h"
#include "solvers/linear/pattern.h"

namespace feder {

/// A fill-reducing order of a graph: order[k] is the vertex eliminated k-th (postordered).
struct Ordering {
  std::vector<int> order;
  std::string name;    ///< "natural", "amd" or "metis"
  double flops = 0.0;  ///< of the factorisation of the graph's own matrix (one unknown per vertex)
};

/// Natural order where it makes no more work than AMD (chains), AMD otherwise, METIS where the work is large
/// enough that it may win (volumes, sheets above about 200 x 200; limits measured, the choice is by predicted
/// flops of both). `edges` are pairs of vertices; `unknowns` per vertex scales the predicted work.
Ordering fill_reducing_order(int vertices, const std::vector<std::pair<int, int>>& edges, int unknowns);

/// A sparse Cholesky factorisation of CHOLMOD with fixed pattern, in the order the matrix is given in.
/// LL^T for positive definite matrices (supernodal or simplicial by predicted fill), simplicial LDL^T without
/// pivoting for quasi-definite ones. CHOLMOD reports an exactly zero or (LL^T) negative pivot; a NaN passes
/// unnoticed, so callers check their residual. CHOLMOD's own headers stay in the source file.
class CholmodFactor {
 public:
  enum class Kind { kLlt, kLdlt };

  CholmodFactor();
  CholmodFactor(CholmodFactor&&) noexcept;
  CholmodFactor& operator=(CholmodFactor&&) noexcept;
  ~CholmodFactor();

  /// Symbolic analysis of a lower pattern. Keeps the pattern in the storage the chosen factorisation reads
  /// without a copy: read it back through `pattern()` before computing slots.
  Status analyze(SymmetricPattern lower, Kind kind);
  const SymmetricPattern& pattern() const;
  bool supernodal() const;
  double flops() const;  ///< predicted, one factorisation
  double factor_entries() const;

  /// values in the order of pattern(). On failure failed_column() tells where.
  Status factor(const double* values);
  int failed_column() const;
  /// x = A^-1 b, both of pattern().size; may be the same array.
  void solve(const double* b, double* x);

  /// CHOLMOD's reciprocal condition estimate from the diagonal of the factor; 0 if a NaN sits there.
  double rcond() const;
  /// Pivots of the last factor: L_kk^2, or D_kk of an LDL^T.
  void read_pivots(VectorXd& out) const;
  /// Signs of the pivots D of the LDL^T.
  struct Signs {
    int positive = 0, negative = 0, other = 0;
  };
  Signs pivot_signs() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace feder
