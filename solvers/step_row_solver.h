#pragma once

#include <Eigen/Cholesky>
#include <vector>

#include "engine/status.h"
#include "engine/step_rows.h"
#include "solvers/integrator.h"
#include "solvers/linear/cholmod_factor.h"

namespace feder {

/// One projection onto every row in turn (notes H3, Kaczmarz; with gamma XPBD): y_k += dy, v += W J_k^T dy
/// with
///   dy = -(J_k v + gamma_k y_k + r_k) / (J_k W J_k^T + gamma_k),  cut where a unilateral row would pull.
/// Gauss-Seidel on the dual system of StepRowSolver. Returns the largest |dy| sqrt(J_k W J_k^T), the change
/// of velocity in the norm of the mass. A row without mobility moves its y at most, without gamma nothing.
double sweep_step_rows(const StepRows& rows, const VectorXd& inverse_mass, VectorXd& v, VectorXd& y,
                       RowWeights weights = RowWeights::kMass);

/// The same rows by a factorisation of their dual Schur complement S = J W J^T + gamma: dense for a few rows,
/// CHOLMOD for many. Unilateral rows by block principal pivoting (Judice and Pires, Computers and Operations
/// Research 21, 1994), which ends for every positive definite S; where every gamma is positive with a line
/// search, which takes fewer factors.
class StepRowSolver {
 public:
  /// v: v_start in, v out. y: the guess in (only its signs count, and only on unilateral rows), multipliers
  /// out. Rows with gamma 0 that move nothing are left alone, y = 0. On failure v is v_start and y 0:
  /// kSingular where rows that hold depend on each other to rounding, kNonFinite, kNotConverged.
  Status solve(const StepRows& rows, const VectorXd& inverse_mass, VectorXd& v, VectorXd& y);
  /// The same for rows that are hard, J v + r = 0 (>= 0 where unilateral) to `tolerance` [of r], and may
  /// depend on each other: gamma > 0 only divides the way into rounds, each with a factor that is kept while
  /// the same rows push (proximal point method on y, Rockafellar, SIAM J. Control Optim. 14, 1976). Of all y
  /// that give v some one. kNotConverged where no v holds all rows, saying what is left, and after 300
  /// rounds.
  Status close(const StepRows& rows, const VectorXd& inverse_mass, double tolerance, VectorXd& v,
               VectorXd& y);
  int rounds() const { return rounds_; }                  ///< of the last close
  int factorizations() const { return factorizations_; }  ///< of the last solve

 private:
  Status begin(const StepRows& rows, const VectorXd& inverse_mass, const VectorXd& v, VectorXd& y);
  void set_right(const StepRows& rows, const VectorXd& start, const VectorXd& r);
  Status pivot(const StepRows& rows, const VectorXd& inverse_mass, const VectorXd& start, VectorXd& v,
               VectorXd& y);
  void search(const StepRows& rows, const VectorXd& v, const VectorXd& y, VectorXd& u, VectorXd& z);
  void assemble(const StepRows& rows, const VectorXd& inverse_mass);
  Status analyze(const StepRows& rows);
  void guess_active(const StepRows& rows, const VectorXd& y);
  void find_wrong(const StepRows& rows, const VectorXd& v, const VectorXd& y);
  Status solve_active(const StepRows& rows, const VectorXd& inverse_mass, const VectorXd& start, VectorXd& v,
                      VectorXd& y);
  void push(const StepRows& rows, const VectorXd& inverse_mass, const VectorXd& start, const VectorXd& y,
            VectorXd& v);
  Status factor_dense();
  Status factor_sparse();
  Status judge_pivot(int row, double pivot) const;
  void solve_factored(const VectorXd& right, VectorXd& x);

  /// Rows up to which the factor is dense: both cost the same at 24 rows of 6 entries and at 120 of 30.
  static constexpr int kDense = 48;

  bool dense_ = true;
  int factorizations_ = 0, rounds_ = 0;
  std::vector<char> active_, factored_;  // factored: the active rows of the factor
  std::vector<int> wrong_;
  VectorXd diagonal_, r_, right_, residual_, correction_, reach_;
  Eigen::MatrixXd S_, cut_;
  Eigen::LLT<Eigen::MatrixXd> llt_;
  // sparse: S in the factor's own order
  std::vector<int> analysed_first_, analysed_column_;
  std::vector<std::vector<std::pair<int, double>>> at_column_;
  std::vector<int> unknown_, row_of_;
  CholmodFactor factor_;
  VectorXd values_, used_, permuted_, pivots_;
};

}  // namespace feder
