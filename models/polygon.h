#pragma once

#include <array>
#include <vector>

#include "engine/state.h"

namespace feder {

/// Cuts a polygon (vertex indices, in order) into count - 2 triangles of the same sense, which keep every
/// vertex. Seen along its mean normal it must not cross itself; false if no cut is found.
bool triangulate(const std::vector<Vector3d>& vertices, const std::vector<int>& polygon,
                 std::vector<std::array<int, 3>>& triangles);

}  // namespace feder
