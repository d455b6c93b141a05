#pragma once

#include "models/scene_file/scene.h"

namespace feder {

// Surfaces to look at, centred at the origin, cylinders along z; body left at -1. Lengths in m.

SceneSurface box_surface(const Vector3d& edges);
SceneSurface sphere_surface(double radius);
SceneSurface cylinder_surface(double radius, double height);

}  // namespace feder
