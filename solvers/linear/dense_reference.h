#pragma once

#include <Eigen/LU>
#include <string>
#include <vector>

#include "engine/kkt.h"
#include "solvers/linear/numbering.h"

namespace feder {

/// The KKT matrix written out densely and solved with complete pivoting: the judge of the other routes in
/// tests. Refuses more than kMostUnknowns unknowns.
class DenseReference {
 public:
  static constexpr const char* kName = "dense";
  static constexpr int kMostUnknowns = 2000;
  static std::string refusal(const System& system, bool geometric);

  Status analyze(const System& system, bool geometric);
  void assemble(const Kkt& kkt);
  Status factor(const Kkt& kkt);
  void reduce(const Kkt& kkt, const VectorXd& b1, const VectorXd& b2);
  void substitute();
  void expand(const Kkt& kkt, const VectorXd& b1, const VectorXd& b2, VectorXd& v, VectorXd& y);

  double flops() const;
  std::string description() const { return "dense LU, complete pivoting"; }
  double rcond() const;
  /// From the eigenvalues of the matrix: slow, and independent of every factorisation.
  Inertia inertia() const;
  const Eigen::MatrixXd& matrix() const { return matrix_; }

 private:
  const System* system_ = nullptr;
  std::vector<int> coordinate_, row_;
  Eigen::MatrixXd matrix_;
  VectorXd rhs_;
  Eigen::FullPivLU<Eigen::MatrixXd> lu_;
};

}  // namespace feder
