#pragma once

#include "models/model.h"

namespace feder {

/// The oscillator with row damping d tau and linear drag c: x'' + 2 delta x' + omega^2 x = 0 with
/// delta = (d tau + c) / (2 m). Under-, critically (delta = omega) and over-damped.
struct DampedOscillator {
  double mass = 1.0;           ///< [kg]
  double stiffness = 100.0;    ///< [N/m]
  double damping_time = 0.02;  ///< tau [s]
  double drag = 0.0;           ///< c [kg/s]
  double length = 1.0;         ///< rest length [m]
  double amplitude = 0.1;      ///< initial elongation [m]; |amplitude| < length
  double velocity = 0.0;       ///< initial velocity along the spring [m/s]
};

/// delta [1/s].
double decay_rate(const DampedOscillator& options);

Model make_damped_oscillator(const DampedOscillator& options = {});
ModelInfo damped_oscillator_model();

}  // namespace feder
