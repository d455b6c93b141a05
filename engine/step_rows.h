#pragma once

#include <limits>
#include <vector>

#include "engine/state.h"

namespace feder {

/// Rows of any width that a state gives rise to and that hold for one step (density of a fluid, the Jacobian
/// of an arm, the residuals of a fit): find v and y with
///
///     W^-1 (v - v_start) = J^T y,      J v + gamma y + r = 0   (on unilateral rows: y >= 0, one of both 0).
///
/// J by rows: entries first[k] to first[k + 1] - 1 are J(k, column[i]) = value[i], a column once per row.
struct StepRows {
  std::vector<int> first = {0};
  std::vector<int> column;    ///< coordinate of v, 3 node + axis in a System
  std::vector<double> value;  ///< J
  VectorXd gamma;             ///< diagonal, >= 0
  VectorXd r;
  bool unilateral = false;  ///< every row can only push

  int count() const { return static_cast<int>(first.size()) - 1; }
  void clear() {
    first.assign(1, 0);
    column.clear();
    value.clear();
  }
  /// Appends one entry to the row that `close_row` will end.
  void add(int at, double entry) {
    column.push_back(at);
    value.push_back(entry);
  }
  void close_row() { first.push_back(static_cast<int>(column.size())); }

  double multiply_row(int k, const double* v) const {
    double sum = 0.0;
    for (int i = first[k]; i < first[k + 1]; ++i) sum += value[i] * v[column[i]];
    return sum;
  }
  /// J_k W J_k^T.
  double mobility(int k, const VectorXd& inverse_mass) const {
    double sum = 0.0;
    for (int i = first[k]; i < first[k + 1]; ++i) sum += value[i] * value[i] * inverse_mass[column[i]];
    return sum;
  }
  /// v += weight W J_k^T.
  void push_row(int k, double weight, const double* inverse_mass, double* v) const {
    for (int i = first[k]; i < first[k + 1]; ++i) v[column[i]] += weight * inverse_mass[column[i]] * value[i];
  }
};

}  // namespace feder
