// The step matrix and its right-hand side as dense matrices over all 3 x nodes coordinates, from the system's
// numbers and tests/support/row_formulas.h alone: nothing here calls a kernel or a Kkt.
#pragma once

#include <cmath>
#include <type_traits>

#include "engine/system.h"
#include "tests/support/row_formulas.h"

namespace feder {

struct DenseRows {
  VectorXd phi;
  Eigen::MatrixXd jacobian;
  std::vector<Eigen::MatrixXd> hessian;  ///< one per row
};

/// phi, J and Hess phi of every row; 0 for slots and rows of stiffness 0. Lengths and edges must not be 0.
inline DenseRows dense_rows(const System& s, const VectorXd& q) {
  const int n = 3 * s.nodes;
  DenseRows out{VectorXd::Zero(s.rows), Eigen::MatrixXd::Zero(s.rows, n),
                std::vector<Eigen::MatrixXd>(s.rows, Eigen::MatrixXd::Zero(n, n))};
  auto put = [&](int row, const int* nodes, const auto& d) {
    out.phi[row] = d.value;
    for (int i = 0; i < d.gradient.size(); ++i) {
      const int r = 3 * nodes[i / 3] + i % 3;
      out.jacobian(row, r) = d.gradient[i];
      for (int j = 0; j < d.gradient.size(); ++j)
        out.hessian[row](r, 3 * nodes[j / 3] + j % 3) = d.hessian(i, j);
    }
  };
  auto points = [&](const int* nodes, int count) {
    VectorXd x(3 * count);
    for (int i = 0; i < count; ++i) x.segment<3>(3 * i) = q.segment<3>(3 * nodes[i]);
    return x;
  };
  for (int k = 0; k < s.distance.size(); ++k) {
    if (!s.distance.active(k)) continue;
    const int nodes[2] = {s.distance.a[k], s.distance.b[k]};
    const double rest = s.distance.rest[k];
    put(k, nodes,
        differentiate<6>([&](const auto* x) { return distance_formula(x, rest); }, points(nodes, 2).data()));
  }
  int row = s.distance.size();
  for_each_stencil_row_type(s.stencil_rows, [&](const auto& list) {
    using Row = typename std::decay_t<decltype(list)>::value_type;
    if constexpr (!requires(Row element) { element.a; })  // rows between anchors have tests of their own
      for (const Row& element : list) {
        const VectorXd x = points(element.nodes.data(), 3);
        for (int i = 0; i < Row::kRows; ++i, ++row) {
          if (element.stiffness == 0.0) continue;
          put(row, element.nodes.data(),
              differentiate<9>(
                  [&](const auto* p) {
                    if constexpr (std::is_same_v<Row, CurvatureRow>)
                      return curvature_formula(p)[i];
                    else
                      return angle_formula(p, element.rest_angle);
                  },
                  x.data()));
        }
      }
  });
  return out;
}

/// Kg = -sum lambda Hess phi.
inline Eigen::MatrixXd dense_geometric(const DenseRows& rows, const VectorXd& lambda) {
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(rows.jacobian.cols(), rows.jacobian.cols());
  for (int k = 0; k < lambda.size(); ++k) K -= lambda[k] * rows.hessian[k];
  return K;
}

/// -df/dq of the user force, from its stencils.
inline Eigen::MatrixXd dense_user_stiffness(const System& s, const State& state) {
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(3 * s.nodes, 3 * s.nodes);
  if (!s.forces.user.stiffness) return K;
  std::size_t size = 0;
  for (const auto& stencil : s.forces.user.stencils) size += 9 * stencil.size() * stencil.size();
  std::vector<double> values(size);
  s.forces.user.stiffness(state.t, state.q, state.v, values.data());
  const double* at = values.data();
  for (const auto& stencil : s.forces.user.stencils)
    for (std::size_t r = 0; r < 3 * stencil.size(); ++r)
      for (std::size_t c = 0; c < 3 * stencil.size(); ++c)
        K(3 * stencil[r / 3] + static_cast<int>(r % 3), 3 * stencil[c / 3] + static_cast<int>(c % 3)) +=
            *at++;
  return K;
}

}  // namespace feder
