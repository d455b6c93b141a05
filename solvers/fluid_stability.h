#pragma once

#include <string>

#include "engine/system.h"
#include "solvers/stability.h"

namespace feder {

/// The fastest rates of a system's fluid linearised at a state, by power iteration: of M^-1/2 K M^-1/2 and
/// M^-1/2 C M^-1/2, K = -dF/dq and C = -dF/dv by differences of the forces.
struct FluidRates {
  double frequency = 0.0;  ///< omega, of the pressure [rad/s]
  double damping = 0.0;    ///< of the viscosity [1/s]
  double courant = 0.0;    ///< the common rule 0.4 h/c [s], infinite without sound
};
/// Estimates from below, within 1e-3 on the lattices tried; all 0 without a fluid.
FluidRates largest_fluid_rates(const System& system, const State& state, int iterations = 60);

/// Stable step of leapfrog and symplectic Euler, whose viscous force lags half a step [s]:
/// symplectic_euler_limit of the largest frequency and damping, as if one mode had them. A bound for the
/// linearised fluid, sharp where one of them decides. Infinite for rates 0.
double fluid_step_limit(const FluidRates& rates);

/// The limit of an integrator when a fluid of these rates joins rows of a limit of their own.
StabilityLimit with_fluid(const std::string& integrator, const StabilityLimit& rows, const FluidRates& rates);

}  // namespace feder
