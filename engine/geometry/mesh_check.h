#pragma once

#include <string>

#include "engine/geometry/triangle_mesh.h"

namespace feder {

/// Accepts a mesh that encloses a solid: every edge is met by two triangles in opposite directions, the
/// triangles at a vertex form one fan, the volume is positive. A component wound the other way is a cavity.
/// Unused vertices and triangles without area are allowed; one that repeats an index is skipped.
/// InputError, each with words of its own and naming the element and the value: no triangles, vertex not
/// finite, index out of range, edge of one triangle (open) or of more than two (not manifold), edge met twice
/// in one direction (inconsistent winding), vertex of several fans (not manifold), volume not finite, zero to
/// rounding (flat) or negative (inside out). Surfaces that cut through each other are not looked for.
void check_closed_mesh(const std::string& where, const TriangleMesh& mesh);

}  // namespace feder
