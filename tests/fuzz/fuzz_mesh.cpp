// Any bytes are an InputError or a mesh as its header promises: indices in range, finite vertices. The first
// byte chooses the format.
#include <cstdint>
#include <string_view>

#include "engine/check.h"
#include "models/mesh_io.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace feder;
  if (size == 0) return 0;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  try {
    const TriangleMesh mesh = data[0] == 'o' ? read_obj("mesh", bytes) : read_stl("mesh", bytes);
    const int count = static_cast<int>(mesh.vertices.size());
    if (mesh.triangles.empty()) __builtin_trap();
    for (const Vector3d& vertex : mesh.vertices)
      if (!vertex.allFinite()) __builtin_trap();
    for (const auto& triangle : mesh.triangles)
      for (const int vertex : triangle)
        if (vertex < 0 || vertex >= count) __builtin_trap();
  } catch (const InputError&) {
  }
  return 0;
}
