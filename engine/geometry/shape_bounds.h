#pragma once

#include <string>

#include "engine/geometry/bounding_volumes.h"
#include "engine/geometry/shape.h"

namespace feder {

/// Smallest box along the world axes around a shape (of a mesh: around its turned box); infinite for a half
/// space.
Aabb bounds(const Shape& shape, const Pose& pose);
/// Largest distance of a point of the shape from its origin [m]; infinite for a half space.
double bounding_radius(const Shape& shape);
/// Throws InputError naming `where` for sizes that are not finite or out of range, or a mesh that is missing.
void check_shape(const std::string& where, const Shape& shape);

}  // namespace feder
