#pragma once

#include "models/model.h"

namespace feder {

/// A free box that spins about nearly its middle axis: it flips over and over (notes C2).
struct AsymmetricTop {
  double mass = 1.0;                               ///< [kg]
  double length = 0.5, width = 0.3, height = 0.1;  ///< edges [m]: the middle axis is y
  double speed = 10.0;                             ///< |angular velocity| [rad/s]
  double tilt = 0.1;                               ///< of the angular velocity from y towards x and z [rad]
};

Model make_asymmetric_top(const AsymmetricTop& options = {});
ModelInfo asymmetric_top_model();

}  // namespace feder
