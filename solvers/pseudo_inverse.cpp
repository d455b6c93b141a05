// With v = x, M = E, p = 0, r = -e the step matrix reads  x = J^T y,  J x + gamma y = e, hence
//   S y = e,  S = J J^T + gamma,  x = J^T y.
// S is singular for more rows than columns (the notes print it for both, slip 9): then the primal side,
//   (J^T J + gamma) x = J^T e.
#include "solvers/pseudo_inverse.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "engine/check.h"

namespace feder {

Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& J, double gamma) {
  const bool dual = J.rows() <= J.cols();
  Eigen::MatrixXd S = dual ? Eigen::MatrixXd(J * J.transpose()) : Eigen::MatrixXd(J.transpose() * J);
  S.diagonal().array() += gamma;
  const Eigen::LLT<Eigen::MatrixXd> factor(S);
  if (factor.info() != Eigen::Success) return Eigen::MatrixXd::Constant(J.cols(), J.rows(), std::nan(""));
  if (!dual) return factor.solve(J.transpose());
  return factor.solve(J).transpose();
}

VectorXd minimum_norm_step(const Eigen::MatrixXd& J, const VectorXd& e, double gamma) {
  return pseudo_inverse(J, gamma) * e;
}

double manipulability(const Eigen::MatrixXd& J) {
  if (J.rows() > J.cols()) return 0.0;
  return Eigen::JacobiSVD<Eigen::MatrixXd>(J).singularValues().prod();
}

double smallest_singular_value(const Eigen::MatrixXd& J) {
  return Eigen::JacobiSVD<Eigen::MatrixXd>(J).singularValues().minCoeff();
}

double Damping::gamma(double smallest) const {
  if (smallest >= threshold) return 0.0;
  const double part = smallest / threshold;
  return most * (1.0 - part * part);
}

void SmallDual::reset(int rows, double gamma) {
  FEDER_CHECK(rows >= 1 && rows <= kMost, "from 1 to 6 rows");
  rows_ = rows;
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j <= i; ++j) S_[kMost * i + j] = i == j ? gamma : 0.0;
}

void SmallDual::add(const double* column) {
  for (int i = 0; i < rows_; ++i)
    for (int j = 0; j <= i; ++j) S_[kMost * i + j] += column[i] * column[j];
}

bool SmallDual::factor() {
  for (int i = 0; i < rows_; ++i)
    for (int j = 0; j <= i; ++j) {
      double sum = S_[kMost * i + j];
      for (int k = 0; k < j; ++k) sum -= S_[kMost * i + k] * S_[kMost * j + k];
      if (i == j && !(sum > 0.0)) return false;
      S_[kMost * i + j] = i == j ? std::sqrt(sum) : sum / S_[kMost * j + j];
    }
  return true;
}

void SmallDual::solve(double* y) const {
  for (int i = 0; i < rows_; ++i) {
    for (int k = 0; k < i; ++k) y[i] -= S_[kMost * i + k] * y[k];
    y[i] /= S_[kMost * i + i];
  }
  for (int i = rows_ - 1; i >= 0; --i) {
    for (int k = i + 1; k < rows_; ++k) y[i] -= S_[kMost * k + i] * y[k];
    y[i] /= S_[kMost * i + i];
  }
}

}  // namespace feder
