// The centre of the smallest sphere through k <= d + 1 points t_j of R^d (notes A13). It lies in their affine
// hull and in the bisecting planes u_j.(c - m_j) = 0, with u_j the unit edges and m_j their midpoints of a
// tree on the points. The notes' tree is the star t_j - t_0; in the shortest tree two close points have an
// edge of their own, whose direction keeps its digits. With the factorisation U P = Q R of the edges
//   c = t_0 + Q y,   R^T y = P^T b,   b_j = u_j.(m_j - t_0);      c = t_0 + U w,   R P^T w = y
// gives centre and weights, c = sum weights_j t_j with sum 1.
#pragma once

#include <Eigen/QR>
#include <limits>

#include "engine/state.h"

namespace feder {

template <int D>
using DVector = Eigen::Matrix<double, D, 1>;
/// d x k; where d is a constant there is room for d + 2 points without allocation.
template <int D>
using FewPoints = Eigen::Matrix < double,
      D, Eigen::Dynamic, Eigen::ColMajor, D, D<0 ? D : D + 2>;
template <int D>
using FewNumbers = Eigen::Matrix < double,
      Eigen::Dynamic, 1, Eigen::ColMajor, D<0 ? D : D + 2, 1>;

/// A pivot of the unit edges below this counts as affine dependence.
inline constexpr double kDependentEdges = 1e-12;

template <int D>
struct Circumcentre {
  bool independent = false;
  DVector<D> centre;      ///< [m]; NaN for dependent points
  FewNumbers<D> weights;  ///< of the centre; dependent: an affine dependence, sums 0
};

template <int D>
struct ShortestTree {
  Eigen::Matrix < double, D, Eigen::Dynamic, Eigen::ColMajor, D, D<0 ? D : D + 1> edges;  ///< unit; 0 stays 0
  FewNumbers<D> lengths;
  Eigen::Matrix < int, Eigen::Dynamic, 2, Eigen::ColMajor, D<0 ? D : D + 2, 2> ends;  ///< parent, child
};

// Prim's algorithm from point 0.
template <int D>
ShortestTree<D> shortest_tree(const FewPoints<D>& t) {
  const Eigen::Index k = t.cols();
  ShortestTree<D> tree;
  tree.edges.resize(t.rows(), k - 1);
  tree.lengths.resize(k - 1);
  tree.ends.resize(k - 1, 2);
  FewNumbers<D> distance = FewNumbers<D>::Constant(k, std::numeric_limits<double>::infinity());
  Eigen::Matrix < int, Eigen::Dynamic, 1, Eigen::ColMajor, D<0 ? D : D + 2, 1> parent;
  parent.setZero(k);
  int newest = 0;
  for (Eigen::Index e = 0; e + 1 < k; ++e) {
    distance[newest] = -1.0;  // in the tree
    int nearest = -1;
    for (int j = 0; j < k; ++j) {
      if (distance[j] < 0.0) continue;
      const double squared = (t.col(j) - t.col(newest)).squaredNorm();
      if (!(squared >= distance[j])) distance[j] = squared, parent[j] = newest;
      if (nearest < 0 || distance[j] < distance[nearest]) nearest = j;
    }
    const auto edge = t.col(nearest) - t.col(parent[nearest]);
    tree.lengths[e] = edge.norm();
    tree.edges.col(e) = edge / (tree.lengths[e] > 0.0 ? tree.lengths[e] : 1.0);
    tree.ends(e, 0) = parent[nearest];
    tree.ends(e, 1) = nearest;
    newest = nearest;
  }
  return tree;
}

/// Any number of points from 1 on; more than d + 1 are always dependent.
template <int D>
Circumcentre<D> circumcentre(const FewPoints<D>& t) {
  const Eigen::Index k = t.cols(), m = k - 1;
  Circumcentre<D> out{true, t.col(0), FewNumbers<D>::Zero(k)};
  out.weights[0] = 1.0;
  if (m == 0) return out;

  const ShortestTree<D> tree = shortest_tree<D>(t);
  const Eigen::ColPivHouseholderQR<decltype(tree.edges)> qr(tree.edges);
  const auto& P = qr.colsPermutation().indices();
  Eigen::Index rank = 0;
  while (rank < std::min(m, t.rows()) && std::abs(qr.matrixQR()(rank, rank)) > kDependentEdges) ++rank;
  const auto R = qr.matrixQR().topLeftCorner(rank, rank).template triangularView<Eigen::Upper>();

  FewNumbers<D> w = FewNumbers<D>::Zero(m);  // on the edges, in pivot order
  out.independent = rank == m;
  if (out.independent) {
    DVector<D> y = DVector<D>::Zero(t.rows());
    for (Eigen::Index i = 0; i < m; ++i)
      y[i] = tree.edges.col(P[i]).dot(0.5 * (t.col(tree.ends(P[i], 0)) - t.col(0)) +
                                      0.5 * (t.col(tree.ends(P[i], 1)) - t.col(0)));
    R.transpose().solveInPlace(y.head(m));
    w = y.head(m);
    R.solveInPlace(w);
    y.applyOnTheLeft(qr.householderQ());
    out.centre += y;
  } else {
    // the first edge that depends on those before it
    w.head(rank) = qr.matrixQR().col(rank).head(rank);
    R.solveInPlace(w.head(rank));
    w[rank] = -1.0;
    out.centre.setConstant(std::numeric_limits<double>::quiet_NaN());
    out.weights[0] = 0.0;
  }
  for (Eigen::Index i = 0; i < m; ++i) {
    const double length = tree.lengths[P[i]], difference = w[i] / (length > 0.0 ? length : 1.0);
    out.weights[tree.ends(P[i], 1)] += difference;
    out.weights[tree.ends(P[i], 0)] -= difference;
  }
  return out;
}

}  // namespace feder
