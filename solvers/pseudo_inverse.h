// J^+ as a special case of the step matrix (notes F4): the dual route with Mt = E, damping as gamma.
#pragma once

#include <Eigen/Core>
#include <array>

#include "engine/state.h"

namespace feder {

/// The step x that makes |J x - e|^2 + gamma |x|^2 least; of equally good ones, for gamma = 0, the shortest.
/// For at most as many rows as columns x = J^T y, (J J^T + gamma) y = e, otherwise (J^T J + gamma) x = J^T e;
/// each needs full rank or gamma > 0, and is not finite without. gamma >= 0 [squared unit of J].
VectorXd minimum_norm_step(const Eigen::MatrixXd& J, const VectorXd& e, double gamma = 0.0);
/// The matrix of that map: J^+ for gamma = 0.
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& J, double gamma = 0.0);

/// Yoshikawa's measure sqrt(det J J^T), the product of the singular values; 0 at singular poses.
double manipulability(const Eigen::MatrixXd& J);
/// Of the min(rows, columns) singular values.
double smallest_singular_value(const Eigen::MatrixXd& J);

/// gamma by the smallest singular value (Maciejewski and Klein, Journal of Robotic Systems 5, 1988): 0 from
/// `threshold` on, growing to `most` at a singular pose.
struct Damping {
  double threshold = 0.1;  ///< unit of J
  double most = 1e-2;      ///< its square
  double gamma(double smallest) const;
};

/// S = A A^T + gamma of at most 6 rows, put together column by column: the same dual Schur complement as
/// StepRowSolver's, without its generality (no allocation; a few hundred nanoseconds).
class SmallDual {
 public:
  static constexpr int kMost = 6;
  void reset(int rows, double gamma);
  void add(const double* column);  ///< S += column column^T
  bool factor();                   ///< L L^T in place; false unless positive definite
  void solve(double* y) const;     ///< y <- S^-1 y

 private:
  int rows_ = 0;
  std::array<double, kMost * kMost> S_{};  // lower triangle, row-major
};

}  // namespace feder
