#include "solvers/linear/row_rank.h"

#include <SuiteSparseQR.hpp>
#include <algorithm>
#include <cmath>
#include <vector>

#include "solvers/linear/dual_schur.h"
#include "solvers/linear/pattern.h"

namespace feder {
namespace {

// Visits the blocks of J over free nodes, row by row: visit(row, node, 3 numbers).
template <class Visit>
void for_each_block(const Kkt& kkt, Visit&& visit) {
  for (const Incidence& i : incidences(*kkt.system)) {
    const double* block = i.block(kkt.u.data(), kkt.jacobian.data());
    visit(i.row, i.node, Vector3d(i.sign * Eigen::Map<const Vector3d>(block)));
  }
}

}  // namespace

VectorXd row_mobility(const Kkt& kkt) {
  VectorXd out = VectorXd::Zero(kkt.system->rows);
  for_each_block(kkt, [&](int row, int node, const Vector3d& J) {
    out[row] += J.dot(kkt.inverse_mass.segment<3>(3 * node).cwiseProduct(J));
  });
  const double largest = out.size() ? out.maxCoeff() : 0.0;
  for (double& x : out)
    if (!(x > 0.0)) x = largest > 0.0 ? largest : 1.0;
  return out;
}

RowRank hard_row_rank(const Kkt& kkt, double tolerance) {
  const System& s = *kkt.system;
  RowRank out;
  std::vector<int> column(s.rows, -1), unknown(3 * s.nodes, -1);
  for (int k = 0; k < s.rows; ++k)
    if (kkt.gamma[k] == 0.0) column[k] = out.hard_rows++;
  int unknowns = 0;
  for (int i = 0; i < 3 * s.nodes; ++i)
    if (s.inverse_mass[i] > 0.0) unknown[i] = unknowns++;

  struct Entry {
    int column, row;
    double value;
  };
  std::vector<Entry> entries;
  std::vector<double> squared(out.hard_rows, 0.0);
  for_each_block(kkt, [&](int row, int node, const Vector3d& J) {
    for (int c = 0; c < 3 && column[row] >= 0; ++c)
      if (unknown[3 * node + c] >= 0 && J[c] != 0.0) {
        entries.push_back({column[row], unknown[3 * node + c], J[c]});
        squared[column[row]] += J[c] * J[c];
      }
  });

  cholmod_common common;
  cholmod_l_start(&common);
  cholmod_triplet* T =
      cholmod_l_allocate_triplet(unknowns, out.hard_rows, entries.size(), 0, CHOLMOD_REAL, &common);
  for (const Entry& e : entries) {
    static_cast<SuiteSparse_long*>(T->i)[T->nnz] = e.row;
    static_cast<SuiteSparse_long*>(T->j)[T->nnz] = e.column;
    static_cast<double*>(T->x)[T->nnz++] = e.value / std::sqrt(squared[e.column]);
  }
  cholmod_sparse* A = cholmod_l_triplet_to_sparse(T, T->nnz, &common);
  auto* QR = SuiteSparseQR_symbolic<double>(SPQR_ORDERING_AMD, 1, A, &common);
  SuiteSparseQR_numeric<double>(tolerance, A, QR, &common);
  std::vector<int> row(out.hard_rows);
  for (int k = 0; k < s.rows; ++k)
    if (column[k] >= 0) row[column[k]] = k;
  for (int j = 0; j < out.hard_rows; ++j)
    if (QR->QRnum->Rdead[j]) out.dependent.push_back(row[QR->QRsym->Qfill ? QR->QRsym->Qfill[j] : j]);
  std::sort(out.dependent.begin(), out.dependent.end());
  out.rank = out.hard_rows - static_cast<int>(out.dependent.size());
  SuiteSparseQR_free<double>(&QR, &common);
  cholmod_l_free_triplet(&T, &common);
  cholmod_l_free_sparse(&A, &common);
  cholmod_l_finish(&common);
  return out;
}

// Refinement with S + eps D on the singular S, D the mobilities: y stays in D^-1 range(S), so its limit has
// the least D-norm; what lies in the range contracts by eps/(lambda + eps).
VectorXd least_norm_multipliers(const System& s, const VectorXd& q, const VectorXd& y) {
  constexpr double kEpsilon = 1e-9;
  constexpr int kRefinements = 5;
  Kkt kkt;
  kkt.prepare(s);
  kkt.set_step(0.0, 0.0);  // hard rows alone
  DualSchur route;
  if (!kkt.evaluate(q).ok() || !route.analyze(s, false).ok()) return y;
  const VectorXd mobility = row_mobility(kkt), zero = VectorXd::Zero(kkt.p.size());
  VectorXd hard = y, out = VectorXd::Zero(s.rows), force, target, reached, v, correction;
  for (int k = 0; k < s.rows; ++k) {
    if (kkt.gamma[k] == 0.0)
      kkt.gamma[k] = kEpsilon * mobility[k];
    else
      hard[k] = 0.0;
  }
  route.assemble(kkt);
  if (!route.factor(kkt).ok()) return y;
  auto apply = [&](const VectorXd& x, VectorXd& Sx) {
    force.setZero(zero.size());
    kkt.add_jacobian_transpose(x, force);
    kkt.multiply_jacobian_inverse_mass(force, Sx);
  };
  apply(hard, target);
  for (int i = 0; i < kRefinements; ++i) {
    apply(out, reached);
    const VectorXd rest = reached - target;
    route.reduce(kkt, zero, rest);
    route.substitute();
    route.expand(kkt, zero, rest, v, correction);
    out += correction;
  }
  return out + (y - hard);
}

}  // namespace feder
