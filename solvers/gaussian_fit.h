#pragma once

#include "engine/gaussians.h"
#include "engine/status.h"

namespace feder {

/// Which Schur complement of the damped step [D^2, -J^T; -J, -mu] is factored. With 80 parameters and 10, 20,
/// 40, 160, 800 points a step takes 38, 45, 61, 161, 1830 us primal, 19, 46, 133, 3950, 123000 us dual; with
/// 20 and with 200 parameters both are equal between a quarter and an eighth as many points (measured).
enum class FitRoute {
  kAuto,    ///< dual up to a fifth as many points as parameters, otherwise primal
  kPrimal,  ///< J^T J + mu D^2, parameters x parameters, dense
  kDual,    ///< J D^-2 J^T + mu, points x points: rows of a step, by StepRowSolver
};

struct GaussianFitOptions {
  FitRoute route = FitRoute::kAuto;
  int most_steps = 200;        ///< tried, rejected ones included
  double first_damping = 0.1;  ///< theta, > 0
  double tolerance = 1e-10;    ///< on `gradient`, > 0
};

struct GaussianFit {
  Status status;            ///< kNotConverged, kNonFinite or kSingular with the reason
  bool primal = false;      ///< the route taken
  int steps = 0;            ///< taken
  int tried = 0;            ///< taken or rejected: each is one factorisation
  double rms = 0.0;         ///< sqrt(|r|^2 / points)
  double gradient = 0.0;    ///< largest cosine between r and a column of J: 0 at a stationary point
  VectorXd residual_norms;  ///< |r| at the start and after each step taken
};

/// Fits `sum` to values[i] at the columns of points (dimension x count) by least squares, from the parameters
/// it has. Ends converged where `gradient` <= tolerance or where |r| is rounding of its terms (4 epsilon).
/// Whatever the status, `sum` is in range and fits no worse than at the start (up to rounding).
/// InputError: no points, sizes that differ, values that are not finite, an empty sum or one out of range,
/// bad options.
GaussianFit fit_gaussians(const Eigen::MatrixXd& points, const VectorXd& values, GaussianSum& sum,
                          const GaussianFitOptions& options = {});

}  // namespace feder
