#pragma once

#include "models/model.h"

namespace feder {

/// One mass on a spring to a world point, moving along the spring: x(t) = amplitude cos(omega t).
struct Oscillator {
  double mass = 1.0;         ///< [kg]
  double stiffness = 100.0;  ///< [N/m]
  double length = 1.0;       ///< rest length [m]
  double amplitude = 0.1;    ///< initial elongation, from rest [m]; |amplitude| < length
};

Model make_oscillator(const Oscillator& options = {});
ModelInfo oscillator_model();

}  // namespace feder
