// phi(q exp(t v)) has the second derivative v.Hess v at t = 0: Hess is taken along the exponential map.
#include "engine/row_rates.h"

#include <cmath>

namespace feder {

void jacobian_rate(const System& s, const State& state, VectorXd& out) {
  out.setZero(s.rows);
  const DistanceRows& rows = s.distance;
  for (int k = 0; k < rows.size(); ++k) {
    if (!std::isinf(rows.stiffness[k])) continue;
    const Vector3d d = state.q.segment<3>(3 * rows.b[k]) - state.q.segment<3>(3 * rows.a[k]),
                   dv = state.v.segment<3>(3 * rows.b[k]) - state.v.segment<3>(3 * rows.a[k]);
    const double length = d.norm(), along = d.dot(dv) / length;
    out[k] = (dv.squaredNorm() - along * along) / length;
  }
  std::size_t at = 0;
  for_each_stencil_row_type(s.stencil_rows, [&](const auto& list) {
    using Row = typename std::decay_t<decltype(list)>::value_type;
    for (const Row& row : list) {
      const Stencil& stencil = s.stencils[at++];
      if (!std::isinf(row.stiffness)) continue;
      const int columns = 3 * row.count();
      VectorXd v(columns);
      for (int c = 0; c < columns; ++c) v[c] = state.v[3 * row.nodes[c / 3] + c % 3];
      Eigen::MatrixXd hessian(columns, columns);
      for (int i = 0; i < Row::kRows; ++i) {
        const Eigen::Matrix<double, Row::kRows, 1> unit = Eigen::Matrix<double, Row::kRows, 1>::Unit(i);
        row.hessian(state.q.data(), unit.data(), hessian);
        out[stencil.first_row + i] = v.dot(hessian * v);
      }
    }
  });
}

}  // namespace feder
