// Rows of a step with their dense matrices.
#pragma once

#include <Eigen/Dense>

#include "engine/step_rows.h"
#include "tests/support/random.h"

namespace feder::test {

using Eigen::MatrixXd;

struct StepRowProblem {
  StepRows rows;
  VectorXd inverse_mass, v;

  MatrixXd jacobian() const {
    MatrixXd J = MatrixXd::Zero(rows.count(), v.size());
    for (int k = 0; k < rows.count(); ++k)
      for (int i = rows.first[k]; i < rows.first[k + 1]; ++i) J(k, rows.column[i]) = rows.value[i];
    return J;
  }
  MatrixXd schur() const {
    const MatrixXd J = jacobian();
    const MatrixXd weighted = J * inverse_mass.asDiagonal();
    MatrixXd S = weighted * J.transpose();
    S.diagonal() += rows.gamma;
    return S;
  }
  VectorXd right() const { return -(rows.r + jacobian() * v); }
  VectorXd residual(const VectorXd& at, const VectorXd& y) const {
    return jacobian() * at + rows.gamma.cwiseProduct(y) + rows.r;
  }
};

// Rows of `width` neighbouring columns among n; each tenth column does not move.
inline StepRowProblem random_rows(std::uint64_t seed, int m, int n, int width, double gamma) {
  Random random(seed);
  StepRowProblem p;
  for (int k = 0; k < m; ++k) {
    const int first = random.below(n - width + 1);
    for (int i = 0; i < width; ++i) p.rows.add(first + i, random.uniform());
    p.rows.close_row();
  }
  p.rows.r = random.numbers(m);
  p.rows.gamma = VectorXd::Zero(m);
  for (int k = 0; k < m && gamma > 0.0; ++k) p.rows.gamma[k] = gamma * random.uniform(0.1, 1.0);
  p.inverse_mass.resize(n);
  for (int i = 0; i < n; ++i) p.inverse_mass[i] = i % 10 == 9 ? 0.0 : random.uniform(0.2, 5.0);
  p.v = random.numbers(n);
  return p;
}

}  // namespace feder::test
