// v = v_start + W J^T y turns J v + gamma y + r = 0 into S y = -(r + J v_start), S = J W J^T + gamma.
#include "solvers/step_row_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "engine/check.h"

namespace feder {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

// sum_i |J_ki| sizes_i
double multiply_sizes(const StepRows& rows, int k, const VectorXd& sizes) {
  double sum = 0.0;
  for (int i = rows.first[k]; i < rows.first[k + 1]; ++i)
    sum += std::abs(rows.value[i]) * sizes[rows.column[i]];
  return sum;
}

}  // namespace

double sweep_step_rows(const StepRows& rows, const VectorXd& inverse_mass, VectorXd& v, VectorXd& y,
                       RowWeights weights) {
  const double share = weights == RowWeights::kHalved ? 0.5 : 1.0;
  double largest = 0.0;
  for (int k = 0; k < rows.count(); ++k) {
    const double mobility = rows.mobility(k, inverse_mass);
    if (mobility + rows.gamma[k] <= 0.0) continue;
    double dy = -share * (rows.multiply_row(k, v.data()) + rows.gamma[k] * y[k] + rows.r[k]) /
                (mobility + rows.gamma[k]);
    if (rows.unilateral) dy = std::max(dy, -y[k]);
    if (dy == 0.0) continue;
    y[k] += dy;
    rows.push_row(k, dy, inverse_mass.data(), v.data());
    largest = std::max(largest, std::abs(dy) * std::sqrt(mobility));
  }
  return largest;
}

// Pattern and order of S, kept while the rows have the same columns.
Status StepRowSolver::analyze(const StepRows& rows) {
  if (rows.first == analysed_first_ && rows.column == analysed_column_) return {};
  const int m = rows.count();
  int columns = 0;
  for (int c : rows.column) columns = std::max(columns, c + 1);
  std::vector<std::vector<int>> at(columns);
  for (int k = 0; k < m; ++k)
    for (int i = rows.first[k]; i < rows.first[k + 1]; ++i) at[rows.column[i]].push_back(k);
  // two rows meet at many columns: each pair once
  std::vector<std::pair<int, int>> edges;
  std::vector<int> seen(m, -1);
  for (int k = 0; k < m; ++k)
    for (int i = rows.first[k]; i < rows.first[k + 1]; ++i)
      for (int j : at[rows.column[i]])
        if (j < k && seen[j] != k) {
          seen[j] = k;
          edges.emplace_back(k, j);
        }
  row_of_ = fill_reducing_order(m, edges, 1).order;
  unknown_.assign(m, -1);
  for (int i = 0; i < m; ++i) unknown_[row_of_[i]] = i;
  for (auto& [i, j] : edges) i = unknown_[i], j = unknown_[j];
  analysed_first_.clear();
  if (Status status = factor_.analyze(make_pattern(m, std::move(edges)), CholmodFactor::Kind::kLlt);
      !status.ok())
    return status;
  analysed_first_ = rows.first;
  analysed_column_ = rows.column;
  return {};
}

// S and its diagonal by rows: row i gathers W J_ic J_jc from the rows j at each of its columns c.
void StepRowSolver::assemble(const StepRows& rows, const VectorXd& inverse_mass) {
  const int m = rows.count();
  at_column_.resize(inverse_mass.size());
  for (auto& list : at_column_) list.clear();
  for (int k = 0; k < m; ++k)
    for (int i = rows.first[k]; i < rows.first[k + 1]; ++i)
      at_column_[rows.column[i]].emplace_back(k, rows.value[i] * inverse_mass[rows.column[i]]);
  if (dense_) {
    S_ = rows.gamma.asDiagonal();
    for (int k = 0; k < m; ++k)
      for (int i = rows.first[k]; i < rows.first[k + 1]; ++i)
        for (const auto& [j, weight] : at_column_[rows.column[i]]) S_(j, k) += weight * rows.value[i];
    diagonal_ = S_.diagonal();
    return;
  }
  const SymmetricPattern& pattern = factor_.pattern();
  values_.resize(pattern.entries());
  diagonal_.resize(m);
  VectorXd gathered = VectorXd::Zero(m);
  for (int column = 0; column < m; ++column) {
    const int k = row_of_[column];
    for (int i = rows.first[k]; i < rows.first[k + 1]; ++i)
      for (const auto& [j, weight] : at_column_[rows.column[i]])
        gathered[unknown_[j]] += weight * rows.value[i];
    gathered[column] += rows.gamma[k];
    diagonal_[k] = gathered[column];
    for (int e = pattern.column_start[column]; e < pattern.column_start[column + 1]; ++e)
      values_[e] = gathered[pattern.row[e]];
    for (int i = rows.first[k]; i < rows.first[k + 1]; ++i)
      for (const auto& [j, weight] : at_column_[rows.column[i]]) gathered[unknown_[j]] = 0.0;
  }
}

// A pivot is the sine squared of the angle between a row and those before it, times its diagonal entry: 0
// but for rounding where the row depends on them.
Status StepRowSolver::judge_pivot(int row, double pivot) const {
  if (pivot > 64.0 * kEpsilon * std::sqrt(static_cast<double>(diagonal_.size())) * diagonal_[row]) return {};
  return Status::failure(StatusCode::kSingular,
                         "row " + std::to_string(row) + " of the step depends on the rows before it");
}

Status StepRowSolver::factor_dense() {
  const int m = static_cast<int>(diagonal_.size());
  cut_ = S_;
  for (int k = 0; k < m; ++k)
    if (!active_[k]) {
      cut_.row(k).setZero();
      cut_.col(k).setZero();
      cut_(k, k) = 1.0;
    }
  llt_.compute(cut_);
  if (llt_.info() != Eigen::Success)
    return Status::failure(StatusCode::kSingular, "rows of the step depend on each other");
  for (int k = 0; k < m; ++k)
    if (active_[k])
      if (Status status = judge_pivot(k, std::pow(llt_.matrixLLT()(k, k), 2)); !status.ok()) return status;
  return {};
}

Status StepRowSolver::factor_sparse() {
  const int m = static_cast<int>(diagonal_.size());
  const SymmetricPattern& pattern = factor_.pattern();
  used_ = values_;
  for (int column = 0; column < m; ++column)
    for (int e = pattern.column_start[column]; e < pattern.column_start[column + 1]; ++e) {
      const int row = pattern.row[e];
      if (!(active_[row_of_[row]] && active_[row_of_[column]])) used_[e] = row == column ? 1.0 : 0.0;
    }
  if (Status status = factor_.factor(used_.data()); !status.ok())
    return factor_.failed_column() < 0 ? status : judge_pivot(row_of_[factor_.failed_column()], 0.0);
  factor_.read_pivots(pivots_);
  for (int i = 0; i < m; ++i)
    if (active_[row_of_[i]])
      if (Status status = judge_pivot(row_of_[i], pivots_[i]); !status.ok()) return status;
  return {};
}

// x = S^-1 right over the active rows, 0 elsewhere.
void StepRowSolver::solve_factored(const VectorXd& right, VectorXd& x) {
  const int m = static_cast<int>(right.size());
  if (dense_) {
    x = right;
    for (int k = 0; k < m; ++k)
      if (!active_[k]) x[k] = 0.0;
    llt_.solveInPlace(x);
    return;
  }
  permuted_.resize(m);
  for (int i = 0; i < m; ++i) permuted_[i] = active_[row_of_[i]] ? right[row_of_[i]] : 0.0;
  factor_.solve(permuted_.data(), permuted_.data());
  for (int i = 0; i < m; ++i) x[row_of_[i]] = permuted_[i];
}

// y over the active rows and v = v_start + W J^T y, refined until J v + gamma y + r is rounding of its terms.
Status StepRowSolver::solve_active(const StepRows& rows, const VectorXd& inverse_mass, const VectorXd& start,
                                   VectorXd& v, VectorXd& y) {
  constexpr int kRefinements = 3;
  constexpr double kGoal = 1e-14, kBound = 1e-9;
  if (factored_ != active_) {
    ++factorizations_;
    factored_.clear();
    if (Status status = dense_ ? factor_dense() : factor_sparse(); !status.ok()) return status;
    factored_ = active_;
  }
  const int m = rows.count();
  solve_factored(right_, y);
  push(rows, inverse_mass, start, y, v);
  residual_.resize(m);
  double last = std::numeric_limits<double>::infinity();
  for (int refinement = 0;; ++refinement) {
    if (!y.allFinite() || !v.allFinite())
      return Status::failure(StatusCode::kNonFinite, "multipliers of the step's rows are not finite");
    double largest = 0.0, scale = 0.0, reach = 0.0;
    const VectorXd sizes = v.cwiseAbs() + start.cwiseAbs();
    for (int k = 0; k < m; ++k) {
      residual_[k] = active_[k] ? -(rows.multiply_row(k, v.data()) + rows.gamma[k] * y[k] + r_[k]) : 0.0;
      if (!active_[k]) continue;
      const double terms = std::abs(r_[k]) + rows.gamma[k] * std::abs(y[k]);
      largest = std::max(largest, std::abs(residual_[k]));
      scale = std::max(scale, terms + multiply_sizes(rows, k, sizes));
      reach = std::max(reach, terms + multiply_sizes(rows, k, reach_));
    }
    if (largest <= kGoal * scale) return {};
    if (refinement == kRefinements || largest > 0.5 * last) {
      if (largest <= kBound * reach) return {};
      std::ostringstream reason;
      reason << "rows of the step nearly depend on each other: " << largest / reach
             << " of their terms is left";
      return Status::failure(StatusCode::kSingular, reason.str());
    }
    last = largest;
    correction_.resize(m);
    solve_factored(residual_, correction_);
    for (int k = 0; k < m; ++k)
      if (correction_[k] != 0.0) rows.push_row(k, correction_[k], inverse_mass.data(), v.data());
    y += correction_;
  }
}

// v = v_start + W J^T y; reach_: the same sum of sizes, what the rounding of v is measured against.
void StepRowSolver::push(const StepRows& rows, const VectorXd& inverse_mass, const VectorXd& start,
                         const VectorXd& y, VectorXd& v) {
  v = start;
  reach_ = start.cwiseAbs();
  for (int k = 0; k < rows.count(); ++k) {
    if (y[k] == 0.0) continue;
    rows.push_row(k, y[k], inverse_mass.data(), v.data());
    for (int i = rows.first[k]; i < rows.first[k + 1]; ++i)
      reach_[rows.column[i]] += std::abs(y[k] * rows.value[i]) * inverse_mass[rows.column[i]];
  }
}

// Rows that push at the start: those of the guess, without one those that are violated.
void StepRowSolver::guess_active(const StepRows& rows, const VectorXd& y) {
  const bool guess = !y.isZero(0.0);
  active_.resize(diagonal_.size());
  for (int k = 0; k < rows.count(); ++k)
    active_[k] = diagonal_[k] > 0.0 && (!rows.unilateral || (guess ? y[k] > 0.0 : right_[k] > 0.0));
}

// The rows of the wrong sign; where they rest, beyond the rounding of w = J v + r.
void StepRowSolver::find_wrong(const StepRows& rows, const VectorXd& v, const VectorXd& y) {
  wrong_.clear();
  const double least = 1e-13 * right_.lpNorm<Eigen::Infinity>();
  for (int k = 0; k < rows.count(); ++k) {
    if (active_[k]) {
      if (y[k] < 0.0) wrong_.push_back(k);
      continue;
    }
    if (!(diagonal_[k] > 0.0)) continue;
    const double w = rows.multiply_row(k, v.data()) + r_[k];
    if (w < -least && w < -16.0 * kEpsilon * (std::abs(r_[k]) + multiply_sizes(rows, k, reach_)))
      wrong_.push_back(k);
  }
}

// S, what is to be held, and a first guess which rows push.
Status StepRowSolver::begin(const StepRows& rows, const VectorXd& inverse_mass, const VectorXd& v,
                            VectorXd& y) {
  const int m = rows.count();
  FEDER_CHECK(rows.gamma.size() == m && rows.r.size() == m, "every row has its gamma and r");
  FEDER_CHECK(v.size() == inverse_mass.size(), "every coordinate has its inverse mass");
  factorizations_ = 0;
  factored_.clear();
  if (y.size() != m) y.setZero(m);
  dense_ = m <= kDense;
  if (!dense_)
    if (Status status = analyze(rows); !status.ok()) return status;
  assemble(rows, inverse_mass);
  set_right(rows, v, rows.r);
  // a NaN anywhere in J, W, gamma, r or v_start shows in one of both
  if (!right_.allFinite() || !diagonal_.allFinite())
    return Status::failure(StatusCode::kNonFinite, "a row of the step is not finite");
  guess_active(rows, y);
  return {};
}

// right = -(r + J v_start)
void StepRowSolver::set_right(const StepRows& rows, const VectorXd& start, const VectorXd& r) {
  r_ = r;
  right_.resize(rows.count());
  for (int k = 0; k < rows.count(); ++k) right_[k] = -(r_[k] + rows.multiply_row(k, start.data()));
}

Status StepRowSolver::solve(const StepRows& rows, const VectorXd& inverse_mass, VectorXd& v, VectorXd& y) {
  const VectorXd start = v;
  Status status = begin(rows, inverse_mass, v, y);
  if (status.ok() && rows.count() > 0) status = pivot(rows, inverse_mass, start, v, y);
  if (!status.ok()) v = start, y.setZero();
  return status;
}

}  // namespace feder
