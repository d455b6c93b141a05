#pragma once

#include <Eigen/Core>
#include <complex>
#include <string>
#include <vector>

#include "engine/system.h"

namespace feder {

// ---- One mode x'' + c x' + omega^2 x = 0: largest stable dt [s]
// -------------------------------------------------- omega_squared [1/s^2] and the damping rate c [1/s] must
// be >= 0; otherwise the exact solution grows and the answer is NaN. Infinity: stable at every step. Zero:
// unstable at every step.

/// |1 + dt s| <= 1 for both roots s: c / omega^2 underdamped, 2 / |s_max| overdamped, 0 undamped.
double explicit_euler_limit(double omega_squared, double c);
/// 2 / omega whatever the damping (kick-drift-kick, the damping of the second kick implicit).
double leapfrog_limit(double omega_squared, double c);
/// 4 / (c + sqrt(c^2 + 4 omega^2)): 2 / omega undamped, 2 / c without stiffness (damping at the old
/// velocity).
double symplectic_euler_limit(double omega_squared, double c);
/// |R(dt s)| <= 1 for both roots, R the RK4 polynomial: 2.8284 / omega undamped, 2.7853 / |s_max| overdamped.
double rk4_limit(double omega_squared, double c);

/// The same along the ray of one root s [1/s]: largest dt with |1 + dt s| <= 1 or |R(dt s)| <= 1; 0 for Re s
/// > 0.
double explicit_euler_limit(std::complex<double> s);
double rk4_limit(std::complex<double> s);

/// The notes' step (implicit Euler linearised with J frozen), notes E8: stable iff 4 M + 2 dt C + dt^2 (Km -
/// Kg) >= 0, so 2 / sqrt(lambda_max(Kg - Km, M)) without damping. Symmetric matrices; M [kg] positive
/// definite; C [kg/s] = J^T D tau J + drag.
double notes_step_limit(const Eigen::MatrixXd& M, const Eigen::MatrixXd& Km, const Eigen::MatrixXd& Kg,
                        const Eigen::MatrixXd& C);

// ---- A system linearised at a state
// ---------------------------------------------------------------------------

/// Predicted limit. dt [s]: infinity if there is none, 0 if no step is stable, NaN if it cannot be predicted.
/// `why` says in every case which frequency, damping or obstacle decided.
struct StabilityLimit {
  double dt;
  std::string why;
};

/// Largest frequency [rad/s] of M^-1/2 (Km + Kg) M^-1/2 over the free coordinates, Km = J^T D J, Kg with
/// lambda = -D phi, plus the stiffness of the user force if it gives one and that of a fluid
/// (solvers/fluid_stability.h). NaN with hard rows (their frequency
/// is infinite), at a degenerate or non-finite state, and if Lanczos does not converge. Modes with negative
/// stiffness grow in the exact solution too and do not count.
double largest_frequency(const System& system, const State& state);

/// Upper bound [1/s] on |s| over all roots of the linearised system: (c + sqrt(c^2 + 4 omega^2))/2 with the
/// largest eigenvalue c of M^-1/2 C M^-1/2 and omega = largest_frequency; omega without damping. RK4 is
/// stable for dt below kRk4Radius times its inverse.
double largest_rate(const System& system, const State& state);
/// Least distance from 0 to the border of RK4's stability region in the left half plane (2.6156, at 122.7
/// degrees).
inline constexpr double kRk4Radius = 2.615;

/// Explicit Euler and RK4 need the whole damped spectrum. Modal where the damping diagonalises with the
/// stiffness (drag proportional to mass; one damping time and no stress); otherwise eigenvalues of the dense
/// companion matrix up to kLargestDenseSize free coordinates and NaN beyond.
StabilityLimit stability_limit_explicit_euler(const System& system, const State& state);
StabilityLimit stability_limit_rk4(const System& system, const State& state);
/// 2 / omega_max for any damping matrix C >= 0: the characteristic form M (z-1)^2 + dt/2 C (z^2-1) + dt^2 K z
/// has its only damped crossing of |z| = 1 at z = -1, where C drops out.
StabilityLimit stability_limit_leapfrog(const System& system, const State& state);
/// As notes_step_limit above, matrix-free; stress comes from Kg at the state.
StabilityLimit stability_limit_notes_step(const System& system, const State& state);

/// The one of an integrator, by its name; NaN for one that has no prediction yet.
StabilityLimit stability_limit(const std::string& integrator, const System& system, const State& state);

inline constexpr int kLargestDenseSize = 300;

/// Frequencies of the finite rows and law springs about a state, hard rows left out and bodies taken at rest.
/// Hard rows only take freedom away, so `largest_frequency` bounds what is left of it (but for the Kg of
/// their own multipliers). NaN at a degenerate or non-finite state and where an eigenvalue is missing.
struct Spectrum {
  double largest_frequency;   ///< [rad/s]; 0 without stiffness
  double smallest_frequency;  ///< above 1e-6 of the largest; NaN beyond kLargestDenseSize and without [rad/s]
  double
      largest_damping_rate;  ///< largest eigenvalue of M^-1/2 C M^-1/2, twice the decay rate of a mode [1/s]
  /// sqrt(x.Kx / x.Mx), the larger one of x = acceleration and x = velocity at the state: how fast the motion
  /// is that begins there [rad/s]; 0 at rest in equilibrium and where something is left out
  double excited_frequency;
  std::string left_out;  ///< the first hard row or turning body, or why there is no answer; else empty
};

/// Where Lanczos may stop: relative residual of the eigenvalue (whose own error is smaller), restarts of 60.
struct LanczosOptions {
  double tolerance = 1e-11;
  int most_restarts = 2000;
};

/// The spectrum and, from the same linearisation, the limits of several integrators.
struct StabilityForecast {
  Spectrum spectrum;
  std::vector<StabilityLimit> limits;
};
StabilityForecast forecast_stability(const System& system, const State& state,
                                     const std::vector<std::string>& integrators,
                                     const LanczosOptions& lanczos = {});

}  // namespace feder
