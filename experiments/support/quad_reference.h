#pragma once

#include <limits>

#include "engine/kkt.h"

namespace feder::experiments {

/// Solution of one linearisation of a system of distance rows, refined in quadruple precision.
struct QuadReference {
  VectorXd v;                                               ///< [m/s]
  double error = std::numeric_limits<double>::quiet_NaN();  ///< last correction, relative; NaN: there is none
};

/// Refines by the kkt and the dual route until the corrections no longer shrink; the lower end wins.
QuadReference quad_reference(const Kkt& kkt);

/// |v|_M = sqrt(v^T M v).
double mass_norm(const System& system, const VectorXd& v);

}  // namespace feder::experiments
