#pragma once

#include "models/model.h"

namespace feder {

/// n x n plates 0.1 x 0.02 x 0.1 m, 0.1 kg each, flat in the xz plane, falling from rest: ball joints at the
/// middle of every shared edge, the plates with x index 0 tied to the world. Hard joints in a flat net are
/// over-constrained, hence springs.
struct PlateNet {
  int n = 10;                 ///< plates along an edge
  double stiffness = 1e6;     ///< of each joint [N/m]; infinite: a hard joint
  double damping_time = 0.0;  ///< tau [s]
  double gravity = 9.81;      ///< along -y [m/s^2]
};

Model make_plate_net(const PlateNet& options = {});
ModelInfo plate_net_model();

}  // namespace feder
