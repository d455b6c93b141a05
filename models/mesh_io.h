#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "engine/geometry/triangle_mesh.h"

namespace feder {

inline constexpr std::size_t kLargestMeshFile = std::size_t{256} << 20;  // bytes

/// Reads an .obj or .stl file (ASCII or binary). InputError names the file, the line or facet, what was found
/// and what was expected; also for a file that does not exist, cannot be read or is larger than 256 MiB.
TriangleMesh read_mesh(const std::filesystem::path& file);

/// Wavefront OBJ: v (x y z, a weight of 1 or a colour after it) and f; polygons are cut into triangles.
/// Texture, normals, groups, materials, lines and points are skipped, anything else is refused. `where` names
/// the source in messages. A face of more than 1000 vertices or one that crosses itself is refused.
TriangleMesh read_obj(const std::string& where, std::string_view text);

/// STL; vertices of equal coordinates become one (0 and -0 are equal). Normals and attributes are skipped.
TriangleMesh read_stl(const std::string& where, std::string_view bytes);

}  // namespace feder
