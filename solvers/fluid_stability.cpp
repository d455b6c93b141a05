#include "solvers/fluid_stability.h"

#include <cmath>
#include <cstdio>
#include <limits>

#include "engine/body.h"
#include "engine/fluid/fluid.h"

namespace feder {
namespace {

// Largest |eigenvalue| of a symmetric map by power iteration, from a vector in which every mode has a part.
template <class Apply>
double largest(const System& s, int iterations, Apply&& apply) {
  VectorXd x(3 * s.nodes);
  for (int i = 0; i < x.size(); ++i)
    x[i] = s.inverse_mass[i] > 0.0 ? std::sin(12.9898 * i + 1.0) + 0.5 * std::cos(78.233 * i) : 0.0;
  double value = 0.0;
  for (int i = 0; i < iterations && x.norm() > 0.0; ++i) {
    x.normalize();
    x = apply(x);
    value = x.norm();
  }
  return value;
}

}  // namespace

FluidRates largest_fluid_rates(const System& s, const State& state, int iterations) {
  FluidRates rates{.courant = std::numeric_limits<double>::infinity()};
  if (!s.fluid) return rates;
  const Fluid& fluid = *s.fluid;
  const FluidMaterial& m = fluid.material();
  const VectorXd root = s.inverse_mass.cwiseSqrt();
  // -M^-1/2 (F(+) - F(-)) / 2 step
  auto difference = [&](const State& ahead, const State& behind, double step) -> VectorXd {
    VectorXd f = VectorXd::Zero(root.size()), back = f;
    fluid.add_forces(ahead.q, ahead.v, f);
    fluid.add_forces(behind.q, behind.v, back);
    return (back - f).cwiseProduct(root) / (2.0 * step);
  };
  State ahead = state, behind = state;
  if (!fluid.incompressible()) {
    rates.courant = 0.4 * m.support / m.sound_speed;
    const double step = 1e-6 * m.support;  // of the fastest particle
    rates.frequency = std::sqrt(largest(s, iterations, [&](const VectorXd& x) {
      const VectorXd w = x.cwiseProduct(root);
      const double scale = step / w.lpNorm<Eigen::Infinity>();
      advance(s, scale, w, state.q, ahead.q);
      advance(s, -scale, w, state.q, behind.q);
      return difference(ahead, behind, scale);
    }));
    ahead.q = behind.q = state.q;
  }
  if (m.viscosity > 0.0)
    rates.damping = largest(s, iterations, [&](const VectorXd& x) {
      const VectorXd w = x.cwiseProduct(root);
      ahead.v = state.v + w;
      behind.v = state.v - w;
      return difference(ahead, behind, 1.0);
    });
  return rates;
}

double fluid_step_limit(const FluidRates& rates) {
  return symplectic_euler_limit(rates.frequency * rates.frequency, rates.damping);
}

StabilityLimit with_fluid(const std::string& integrator, const StabilityLimit& rows,
                          const FluidRates& rates) {
  const double squared = rates.frequency * rates.frequency;
  if (squared == 0.0 && rates.damping == 0.0) return rows;
  if (integrator == "implicit_euler_newton")
    return {std::nan(""), "none: its matrix has no stiffness of the fluid, it may not converge"};
  double dt =
      fluid_step_limit(rates);  // also of implicit methods, which take the fluid at the start of a step
  if (integrator == "explicit_euler") dt = explicit_euler_limit(squared, rates.damping);
  if (integrator == "rk4") dt = rk4_limit(squared, rates.damping);
  char text[96];
  std::snprintf(text, sizeof text, "fluid: omega = %.6g rad/s, damping rate %.6g 1/s", rates.frequency,
                rates.damping);
  if (rows.dt == std::numeric_limits<double>::infinity()) return {dt, text};
  // squares of frequencies add up at most
  return {dt == 0.0 ? 0.0 : 1.0 / std::hypot(1.0 / dt, 1.0 / rows.dt),
          std::string(text) + "; rows: " + rows.why};
}

}  // namespace feder
