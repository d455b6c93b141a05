// Stability limits of single modes and of small dense pencils.
//
// Leapfrog. With delta = dt c / 2, eliminating v_n between the implicit second kick of one step and the
// explicit first kick of the next gives the staggered form  v_{n+1/2} = alpha v_{n-1/2} - beta x_n,  x_{n+1}
// = x_n + dt v_{n+1/2},
//   alpha = (1 - delta)/(1 + delta),  beta = dt omega^2/(1 + delta),
// of trace 1 + alpha - dt beta and determinant alpha. Jury's |trace| <= 1 + det reads dt beta <= 2 (1 +
// alpha) = 4/(1 + delta), that is dt <= 2/omega: delta drops out.
//
// Notes' step (E8): with mu = 1/dt, each x allows mu >= mu_x, the root of 4 mu^2 + 2 mu x.Cx - x.(Kg - Km)x =
// 0 (x.Mx = 1). The largest mu_x is found by iterating on the top eigenvector of Kg - Km - 2 mu C: mu rises
// monotonically.
//
// Symplectic Euler the same way: each x allows mu >= mu_x, the larger root of 4 mu^2 - 2 mu x.Cx - x.Kx = 0,
// and mu rises on the top eigenvector of K + 2 mu C.
#include "solvers/stability_modes.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

#include "solvers/stability.h"

namespace feder {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Both roots of s^2 + c s + omega^2 = 0; the smaller real one without cancellation.
template <class RayLimit>
double limit_of_both_roots(double omega_squared, double c, RayLimit&& limit) {
  if (!(omega_squared >= 0.0 && c >= 0.0)) return kNaN;
  const double discriminant = 0.25 * c * c - omega_squared;
  if (discriminant < 0.0) return limit({-0.5 * c, std::sqrt(-discriminant)});
  const double larger = 0.5 * c + std::sqrt(discriminant);
  const double smaller = larger > 0.0 ? omega_squared / larger : 0.0;
  return std::min(limit({-larger, 0.0}), limit({-smaller, 0.0}));
}

// |1 + z + z^2/2 + z^3/6 + z^4/24|
double rk4_amplification(std::complex<double> z) {
  return std::abs(1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0))));
}

}  // namespace

double explicit_euler_limit(std::complex<double> s) {
  return std::norm(s) > 0.0 ? std::max(0.0, -2.0 * s.real() / std::norm(s)) : kInfinity;
}

double rk4_limit(std::complex<double> s) {
  const double magnitude = std::abs(s);
  if (magnitude == 0.0) return kInfinity;
  if (s.real() > 0.0) return 0.0;
  // every ray of the left half plane leaves the region once, at a radius between 2.61 and 2.97
  const std::complex<double> ray = s / magnitude;
  double inside = 2.0, outside = 4.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (inside + outside);
    (rk4_amplification(middle * ray) <= 1.0 ? inside : outside) = middle;
  }
  return inside / magnitude;
}

double explicit_euler_limit(double omega_squared, double c) {
  return limit_of_both_roots(omega_squared, c,
                             [](std::complex<double> s) { return explicit_euler_limit(s); });
}

double rk4_limit(double omega_squared, double c) {
  return limit_of_both_roots(omega_squared, c, [](std::complex<double> s) { return rk4_limit(s); });
}

double leapfrog_limit(double omega_squared, double c) {
  if (!(omega_squared >= 0.0 && c >= 0.0)) return kNaN;
  return omega_squared > 0.0 ? 2.0 / std::sqrt(omega_squared) : kInfinity;
}

double symplectic_euler_limit(double omega_squared, double c) {
  if (!(omega_squared >= 0.0) || !(c >= 0.0)) return kNaN;
  const double rate = c + std::sqrt(c * c + 4.0 * omega_squared);
  return rate > 0.0 ? 4.0 / rate : kInfinity;
}

double notes_step_rate(const std::function<std::optional<VectorXd>(double)>& top_vector,
                       const std::function<RayleighForms(const VectorXd&)>& forms, double zero,
                       double tolerance) {
  double mu = 0.0;
  for (int i = 0; i < 100; ++i) {
    const std::optional<VectorXd> x = top_vector(mu);
    if (!x) return kNaN;
    const auto [excess, damping] = forms(*x);  // x.(Kg - Km)x and x.Cx
    if (!(excess > zero)) return std::isnan(excess) ? kNaN : mu;
    // positive root of 4 mu^2 + 2 mu damping - excess, without cancellation
    const double next = excess / (damping + std::sqrt(damping * damping + 4.0 * excess));
    if (std::abs(next - mu) <= tolerance * next) return next;
    mu = std::max(mu, next);
  }
  return kNaN;
}

double symplectic_euler_rate(const std::function<std::optional<VectorXd>(double)>& top_vector,
                             const std::function<RayleighForms(const VectorXd&)>& forms,
                             const VectorXd& first, double tolerance) {
  double mu = 0.0;
  std::optional<VectorXd> x = first;
  for (int i = 0; i < 100; ++i) {
    const auto [stiffness, damping] = forms(*x);
    const double discriminant = damping * damping + 4.0 * stiffness;
    if (std::isnan(discriminant)) return kNaN;
    // larger root of 4 mu^2 - 2 mu damping - stiffness, if there is one
    const double next = discriminant > 0.0 ? 0.25 * (damping + std::sqrt(discriminant)) : 0.0;
    if (i > 0 && next - mu <= tolerance * next) return std::max(mu, next);
    mu = std::max(mu, next);
    x = top_vector(mu);
    if (!x) return kNaN;
  }
  return kNaN;
}

double notes_step_limit(const Eigen::MatrixXd& M, const Eigen::MatrixXd& Km, const Eigen::MatrixXd& Kg,
                        const Eigen::MatrixXd& C) {
  const Eigen::MatrixXd excess = Kg - Km;
  const double mu = notes_step_rate(
      [&](double at) -> std::optional<VectorXd> {
        const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> eigen(excess - 2.0 * at * C, M);
        if (eigen.info() != Eigen::Success) return std::nullopt;
        return eigen.eigenvectors().rightCols<1>();
      },
      [&](const VectorXd& x) {
        return RayleighForms{x.dot(excess * x), x.dot(C * x)};
      },
      1e-13 * (Km.norm() + Kg.norm()) / M.diagonal().minCoeff(), 1e-13);
  return 1.0 / mu;
}

}  // namespace feder
