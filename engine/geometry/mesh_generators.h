#pragma once

#include <string>

#include "engine/geometry/triangle_mesh.h"

namespace feder {

// Closed surfaces centred at the origin, counter-clockwise seen from outside; curved ones have all vertices
// on the true surface, so that a convex solid contains its mesh and the volume converges with order 2.
// Lengths [m] must be finite and > 0, otherwise InputError naming `where`; so for a number of segments that
// is too small, or for which the mesh would have more vertices than an index can count.

/// Vertex i lies at the low or high x, y, z by the bits 0, 1, 2 of i; 12 triangles.
TriangleMesh box_mesh(const std::string& where, const Vector3d& edges);

// Rings of 4, 8, ..., 4 n vertices from each pole to the widest ring: triangles of nearly equal shape and no
// needles at the poles. n >= 1 is the number of segments of a quarter circle.

/// 8 n^2 triangles; n = 1 is an octahedron.
TriangleMesh sphere_mesh(const std::string& where, double radius, int n);
/// Axis z; 8 n^2 + 8 n triangles, those of the wall as long as the cylinder.
TriangleMesh cylinder_mesh(const std::string& where, double radius, double height, int n);
/// All points within `radius` of the segment from -half_length to +half_length on z; 8 n^2 + 8 n triangles.
TriangleMesh capsule_mesh(const std::string& where, double radius, double half_length, int n);

/// Axis z, circle radius `major` > tube radius `minor`; 2 around * across triangles, around and across >= 3.
TriangleMesh torus_mesh(const std::string& where, double major, double minor, int around, int across);

}  // namespace feder
