#pragma once

#include <cmath>

#include "models/model.h"

namespace feder {

/// Scene S3b(nx, ny): ny rows of nx plates 0.2 x 0.02 x 0.2 m, 0.4 kg each, falling from rest. Each row hangs
/// as a V: the first round(nx / 3) plates go 60 degrees down, the rest straight back up to the start height.
/// Ball joints at the middle of every shared edge, both ends of every row tied to the world.
struct PlateBridge {
  int nx = 30;                  ///< plates along a row
  int ny = 10;                  ///< rows
  double stiffness = INFINITY;  ///< of each joint [N/m]; infinite: a hard joint
  double damping_time = 0.0;    ///< tau [s]
  double gravity = 9.81;        ///< along -y [m/s^2]
};

Model make_plate_bridge(const PlateBridge& options = {});
ModelInfo plate_bridge_model();

}  // namespace feder
