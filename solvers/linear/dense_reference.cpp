#include "solvers/linear/dense_reference.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace feder {

std::string DenseReference::refusal(const System& s, bool) {
  const int size = s.free_count + s.active_rows;
  return size <= kMostUnknowns ? ""
                               : "dense route takes at most " + std::to_string(kMostUnknowns) +
                                     " unknowns, the scene has " + std::to_string(size);
}

Status DenseReference::analyze(const System& s, bool) {
  system_ = &s;
  coordinate_.clear();
  row_.clear();
  for (int i = 0; i < 3 * s.nodes; ++i)
    if (s.free[i / 3] >> i % 3 & 1) coordinate_.push_back(i);
  for (int k = 0; k < s.rows; ++k)
    if (s.active(k)) row_.push_back(k);
  const Eigen::Index size = static_cast<Eigen::Index>(coordinate_.size() + row_.size());
  matrix_ = Eigen::MatrixXd::Zero(size, size);
  return {};
}

// Column by column through the products of Kkt, an assembly of its own.
void DenseReference::assemble(const Kkt& kkt) {
  const Eigen::Index n = static_cast<Eigen::Index>(coordinate_.size());
  VectorXd v = VectorXd::Zero(3 * system_->nodes), Jv, Mv;
  for (Eigen::Index j = 0; j < n; ++j) {
    v[coordinate_[j]] = 1.0;
    kkt.multiply_jacobian(v, Jv);
    Mv = kkt.mass.cwiseProduct(v);
    kkt.add_geometric(v, Mv);
    for (Eigen::Index i = 0; i < n; ++i) matrix_(i, j) = Mv[coordinate_[i]];
    for (std::size_t k = 0; k < row_.size(); ++k)
      matrix_(n + static_cast<Eigen::Index>(k), j) = matrix_(j, n + static_cast<Eigen::Index>(k)) =
          -Jv[row_[k]];
    v[coordinate_[j]] = 0.0;
  }
  for (std::size_t k = 0; k < row_.size(); ++k) {
    const Eigen::Index i = n + static_cast<Eigen::Index>(k);
    matrix_(i, i) = -kkt.gamma[row_[k]];
  }
}

Status DenseReference::factor(const Kkt&) {
  if (!matrix_.allFinite())
    return Status::failure(StatusCode::kNonFinite, "KKT matrix has a non-finite entry");
  lu_.compute(matrix_);
  if (!lu_.isInvertible())
    return Status::failure(StatusCode::kSingular, "KKT matrix has rank " + std::to_string(lu_.rank()) +
                                                      " of " + std::to_string(matrix_.rows()));
  return {};
}

void DenseReference::reduce(const Kkt&, const VectorXd& b1, const VectorXd& b2) {
  rhs_.resize(matrix_.rows());
  const Eigen::Index n = static_cast<Eigen::Index>(coordinate_.size());
  for (Eigen::Index i = 0; i < n; ++i) rhs_[i] = b1[coordinate_[i]];
  for (std::size_t k = 0; k < row_.size(); ++k) rhs_[n + static_cast<Eigen::Index>(k)] = b2[row_[k]];
}

void DenseReference::substitute() {
  rhs_ = lu_.solve(rhs_).eval();
}

void DenseReference::expand(const Kkt&, const VectorXd&, const VectorXd&, VectorXd& v, VectorXd& y) {
  const Eigen::Index n = static_cast<Eigen::Index>(coordinate_.size());
  v.setZero(3 * system_->nodes);
  y.setZero(system_->rows);
  for (Eigen::Index i = 0; i < n; ++i) v[coordinate_[i]] = rhs_[i];
  for (std::size_t k = 0; k < row_.size(); ++k) y[row_[k]] = rhs_[n + static_cast<Eigen::Index>(k)];
}

double DenseReference::flops() const {
  const double size = static_cast<double>(matrix_.rows());
  return 2.0 / 3.0 * size * size * size;
}

double DenseReference::rcond() const {
  return lu_.rcond();
}

Inertia DenseReference::inertia() const {
  const VectorXd eigenvalues =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix_, Eigen::EigenvaluesOnly).eigenvalues();
  Inertia out;
  for (double e : eigenvalues) ++(e > 0.0 ? out.positive : e < 0.0 ? out.negative : out.zero);
  return out;
}

}  // namespace feder
