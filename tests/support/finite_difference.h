// Central differences of fourth order: error O(step^4) + O(rounding / step).
#pragma once

#include "engine/state.h"

namespace feder {

/// df/dx of a scalar function f(VectorXd).
template <class Function>
VectorXd finite_gradient(Function&& f, VectorXd x, double step) {
  VectorXd gradient(x.size());
  for (int i = 0; i < x.size(); ++i) {
    const double at = x[i];
    auto value = [&](double offset) {
      x[i] = at + offset;
      return f(x);
    };
    const double near = value(step) - value(-step), far = value(2.0 * step) - value(-2.0 * step);
    gradient[i] = (8.0 * near - far) / (12.0 * step);
    x[i] = at;
  }
  return gradient;
}

/// df/dx of a vector function f(VectorXd) -> VectorXd.
template <class Function>
Eigen::MatrixXd finite_jacobian(Function&& f, VectorXd x, double step) {
  Eigen::MatrixXd jacobian(f(x).size(), x.size());
  for (int i = 0; i < x.size(); ++i) {
    const double at = x[i];
    auto value = [&](double offset) -> VectorXd {
      x[i] = at + offset;
      return f(x);
    };
    const VectorXd near = value(step) - value(-step), far = value(2.0 * step) - value(-2.0 * step);
    jacobian.col(i) = (8.0 * near - far) / (12.0 * step);
    x[i] = at;
  }
  return jacobian;
}

}  // namespace feder
