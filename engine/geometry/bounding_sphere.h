#pragma once

#include <span>

#include "engine/geometry/bounding_volumes.h"

namespace feder {

/// The ball about the mean of the points through the farthest one (notes A2): contains all, radius at most
/// 2 (1 - 1/n) times the smallest possible. Two passes. Empty without points. InputError names a point [m]
/// that is not finite.
Sphere bounding_sphere(std::span<const Vector3d> points);

}  // namespace feder
