#pragma once

#include <gtest/gtest.h>

#include "solvers/ida_system.h"
#include "tests/support/finite_difference.h"

namespace feder::test {

inline Eigen::MatrixXd dense(const IdaSystem& system, const VectorXd& values) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(system.unknowns(), system.unknowns());
  for (int column = 0; column < system.unknowns(); ++column)
    for (auto k = system.column_starts()[column]; k < system.column_starts()[column + 1]; ++k)
      out(system.row_indices()[k], column) = values[k];
  return out;
}

/// Largest difference between dF/dy + cj dF/dy' and finite differences of the residual, of the largest entry.
inline double jacobian_error(const System& s, const State& state, IdaForm form) {
  IdaSystem system(s, state, form);
  VectorXd y(system.unknowns()), y_prime(system.unknowns()), values(system.nonzeros());
  EXPECT_TRUE(system.initial(state, y.data(), y_prime.data()).ok());
  const double cj = 3.7;
  auto residual = [&](const VectorXd& at) {
    const VectorXd rate = y_prime + cj * (at - y);
    VectorXd r(system.unknowns());
    EXPECT_TRUE(system.residual(state.t, at.data(), rate.data(), r.data()).ok());
    return r;
  };
  const Eigen::MatrixXd finite = finite_jacobian(residual, y, 1e-4);
  EXPECT_TRUE(system.jacobian(state.t, y.data(), cj, values.data()).ok());
  return (dense(system, values) - finite).cwiseAbs().maxCoeff() / finite.cwiseAbs().maxCoeff();
}

}  // namespace feder::test
