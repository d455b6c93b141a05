// The row functions written a second time, in other words than the engine's, for every number type: the
// reference for Jacobians and Hessians by automatic differentiation. x holds 3 numbers per node, in the row's
// own node order.
#pragma once

#include <array>
#include <cmath>

#include "engine/state.h"
#include "unsupported/Eigen/AutoDiff"

namespace feder {

template <class T>
using Triplet = std::array<T, 3>;

template <class T>
T dot3(const Triplet<T>& x, const Triplet<T>& y) {
  T sum = x[0] * y[0];
  sum += x[1] * y[1];
  sum += x[2] * y[2];
  return sum;
}

template <class T>
Triplet<T> difference3(const T* from, const T* to) {
  Triplet<T> d;
  for (int c = 0; c < 3; ++c) d[c] = to[c] - from[c];
  return d;
}

template <class T>
Triplet<T> cross3(const Triplet<T>& x, const Triplet<T>& y) {
  Triplet<T> z;
  for (int c = 0; c < 3; ++c) {
    const int i = (c + 1) % 3, j = (c + 2) % 3;
    z[c] = x[i] * y[j];
    z[c] -= x[j] * y[i];
  }
  return z;
}

template <class T>
T norm3(const Triplet<T>& x) {
  using std::sqrt;
  const T squared = dot3(x, x);
  const T length = sqrt(squared);
  return length;
}

template <class T>
Triplet<T> unit3(const Triplet<T>& x) {
  const T length = norm3(x);
  Triplet<T> u;
  for (int c = 0; c < 3; ++c) u[c] = x[c] / length;
  return u;
}

/// |x_1 - x_0| - rest.
template <class T>
T distance_formula(const T* x, double rest) {
  T phi = norm3(difference3(x, x + 3));
  phi -= T(rest);
  return phi;
}

/// 2 t_a x t_b / (1 + t_a.t_b) with the unit tangents of both edges.
template <class T>
Triplet<T> curvature_formula(const T* x) {
  const Triplet<T> t_a = unit3(difference3(x, x + 3)), t_b = unit3(difference3(x + 3, x + 6));
  T below = dot3(t_a, t_b);
  below += T(1.0);
  Triplet<T> kappa = cross3(t_a, t_b);
  for (int c = 0; c < 3; ++c) {
    const T twice = kappa[c] * T(2.0);
    kappa[c] = twice / below;
  }
  return kappa;
}

/// 2 atan2(|t_a - t_b|, |t_a + t_b|) - rest.
template <class T>
T angle_formula(const T* x, double rest) {
  using std::atan2;
  const Triplet<T> t_a = unit3(difference3(x, x + 3)), t_b = unit3(difference3(x + 3, x + 6));
  Triplet<T> apart, together;
  for (int c = 0; c < 3; ++c) {
    apart[c] = t_a[c] - t_b[c];
    together[c] = t_a[c] + t_b[c];
  }
  const T half = atan2(norm3(apart), norm3(together));
  T psi = half * T(2.0);
  psi -= T(rest);
  return psi;
}

/// Value, gradient and Hessian of a scalar function of N numbers, f(const T* x) -> T for any T.
template <int N>
struct Derivatives {
  double value;
  Eigen::Matrix<double, N, 1> gradient;
  Eigen::Matrix<double, N, N> hessian;
};

template <int N, class Function>
Derivatives<N> differentiate(Function&& f, const double* x) {
  using Once = Eigen::AutoDiffScalar<Eigen::Matrix<double, N, 1>>;
  using Twice = Eigen::AutoDiffScalar<Eigen::Matrix<Once, N, 1>>;
  std::array<Twice, N> seeded;
  for (int i = 0; i < N; ++i) {
    seeded[i].value() = Once(x[i], N, i);
    for (int j = 0; j < N; ++j) {
      seeded[i].derivatives()[j].value() = i == j ? 1.0 : 0.0;
      seeded[i].derivatives()[j].derivatives().setZero();
    }
  }
  const Twice out = f(seeded.data());
  Derivatives<N> d;
  d.value = out.value().value();
  d.gradient = out.value().derivatives();
  for (int i = 0; i < N; ++i) d.hessian.row(i) = out.derivatives()[i].derivatives().transpose();
  return d;
}

}  // namespace feder
