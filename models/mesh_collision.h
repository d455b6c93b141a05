#pragma once

#include "models/model.h"

namespace feder {

/// Two rings, as meshes, fly at each other in free space and spin.
struct MeshCollision {
  double speed = 2.0;        ///< of approach, along x [m/s]
  double offset = 0.1;       ///< of their paths, along y [m]
  double spin = 3.0;         ///< of both, about an axis askew to all of theirs [rad/s]
  double restitution = 0.5;  ///< e in [0, 1]
  double friction = 0.3;     ///< Coulomb's mu
  double density = 1000.0;   ///< of the first [kg/m^3]
  double ratio = 2.0;        ///< density of the second over that
  double radius = 0.2;       ///< of the rings' circle [m]
  double tube = 0.06;        ///< radius of the rings' tube, below `radius` [m]
  int detail = 12;           ///< corners around the tube; along the ring there are twice as many
};

Model make_mesh_collision(const MeshCollision& options = {});
ModelInfo mesh_collision_model();

}  // namespace feder
