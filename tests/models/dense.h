// Dense matrices over the free coordinates, taken column by column from the parts of Kkt.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <vector>

#include "engine/kkt.h"

namespace feder {

inline std::vector<int> free_coordinates(const System& s) {
  std::vector<int> list;
  for (int i = 0; i < 3 * s.nodes; ++i)
    if (s.inverse_mass[i] > 0.0) list.push_back(i);
  return list;
}

inline VectorXd dense_mass(const System& s) {
  VectorXd m(s.free_count);
  const std::vector<int> at = free_coordinates(s);
  for (int i = 0; i < m.size(); ++i) m[i] = s.inertia[at[i]];
  return m;
}

/// Kkt at q with J evaluated; the test fails if a row is degenerate.
inline Kkt evaluated(const System& s, const VectorXd& q) {
  Kkt kkt;
  kkt.prepare(s);
  kkt.set_step(1.0, 0.0);
  const Status status = kkt.evaluate(q);
  EXPECT_TRUE(status.ok()) << status.reason;
  return kkt;
}

/// J^T D J.
inline Eigen::MatrixXd dense_stiffness(const System& s, const VectorXd& q) {
  Kkt kkt = evaluated(s, q);
  const std::vector<int> at = free_coordinates(s);
  Eigen::MatrixXd J(s.rows, s.free_count);
  VectorXd unit = VectorXd::Zero(3 * s.nodes), column;
  for (int c = 0; c < s.free_count; ++c) {
    unit[at[c]] = 1.0;
    kkt.multiply_jacobian(unit, column);
    J.col(c) = column;
    unit[at[c]] = 0.0;
  }
  return J.transpose() * s.stiffness.asDiagonal() * J;
}

/// Kg = -sum_k lambda_k Hess phi_k with lambda = -d phi.
inline Eigen::MatrixXd dense_geometric(const System& s, const State& state) {
  Kkt kkt = evaluated(s, state.q);
  const VectorXd lambda = -s.stiffness.cwiseProduct(kkt.phi);
  kkt.set_geometric_stiffness(GeometricStiffness::kFull, 1.0, state, lambda);
  const std::vector<int> at = free_coordinates(s);
  Eigen::MatrixXd K(s.free_count, s.free_count);
  VectorXd unit = VectorXd::Zero(3 * s.nodes), column;
  for (int c = 0; c < s.free_count; ++c) {
    unit[at[c]] = 1.0;
    column.setZero(3 * s.nodes);
    kkt.add_geometric(unit, column);
    for (int r = 0; r < s.free_count; ++r) K(r, c) = column[at[r]];
    unit[at[c]] = 0.0;
  }
  return K;
}

/// sqrt of the eigenvalues of K x = omega^2 M x, ascending; negative rounding counts as 0.
inline VectorXd pencil_frequencies(const Eigen::MatrixXd& K, const VectorXd& mass) {
  const VectorXd scale = mass.cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * K * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled, Eigen::EigenvaluesOnly);
  return eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt();
}

}  // namespace feder
