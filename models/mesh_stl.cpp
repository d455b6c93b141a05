#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <unordered_map>

#include "engine/check.h"
#include "models/mesh_io.h"
#include "models/mesh_text.h"
#include "models/parameters.h"

namespace feder {
namespace {

constexpr std::size_t kHeader = 84, kFacet = 50;  // bytes

/// Gives equal places one index.
class Merger {
 public:
  int index(const Vector3d& x, TriangleMesh& mesh) {
    const auto [found, is_new] =
        known_.try_emplace(x + Vector3d::Zero(), static_cast<int>(mesh.vertices.size()));
    if (is_new) mesh.vertices.push_back(x);
    return found->second;
  }

 private:
  struct Hash {
    std::size_t operator()(const Vector3d& x) const {
      std::uint64_t hash = 0;
      for (const double c : {x[0], x[1], x[2]}) {
        hash = (hash ^ std::bit_cast<std::uint64_t>(c)) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 29;
      }
      return static_cast<std::size_t>(hash);
    }
  };
  std::unordered_map<Vector3d, int, Hash> known_;
};

std::uint32_t read_uint32(const char* at) {
  std::uint32_t value = 0;
  for (int i = 3; i >= 0; --i) value = value << 8 | static_cast<unsigned char>(at[i]);
  return value;
}

TriangleMesh read_binary(const std::string& where, std::string_view bytes) {
  const std::uint64_t facets = read_uint32(bytes.data() + kHeader - 4);
  if (bytes.size() != kHeader + kFacet * facets)
    throw InputError(where + ": " + std::to_string(facets) + " facets in a file of " +
                     std::to_string(bytes.size()) + " bytes, expected " +
                     std::to_string(kHeader + kFacet * facets) + " bytes");
  TriangleMesh mesh;
  Merger merger;
  for (std::uint64_t facet = 0; facet < facets; ++facet) {
    const char* at = bytes.data() + kHeader + kFacet * facet + 12;  // after the normal
    std::array<int, 3> triangle{};
    for (int& vertex : triangle) {
      Vector3d x;
      for (int axis = 0; axis < 3; ++axis, at += 4) {
        x[axis] = static_cast<double>(std::bit_cast<float>(read_uint32(at)));
        require_finite(where + ": facet " + std::to_string(facet), "coordinate", x[axis], "m");
      }
      vertex = merger.index(x, mesh);
    }
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

std::string keyword(MeshText& text) {
  std::string word(text.word_anywhere());
  for (char& c : word)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return word;
}

void require_word(MeshText& text, const char* expected) {
  if (keyword(text) != expected) text.fail(std::string("'") + expected + "'");
}

/// From "normal" to "endfacet".
std::array<int, 3> read_facet(MeshText& text, Merger& merger, TriangleMesh& mesh) {
  require_word(text, "normal");
  for (int i = 0; i < 3; ++i) static_cast<void>(text.word_anywhere());
  require_word(text, "outer");
  require_word(text, "loop");
  std::array<int, 3> triangle{};
  for (int& vertex : triangle) {
    require_word(text, "vertex");
    Vector3d x;
    for (int axis = 0; axis < 3; ++axis) x[axis] = text.number("a coordinate");
    vertex = merger.index(x, mesh);
  }
  require_word(text, "endloop");
  require_word(text, "endfacet");
  return triangle;
}

TriangleMesh read_ascii(const std::string& where, std::string_view content) {
  MeshText text(where, content);
  TriangleMesh mesh;
  Merger merger;
  text.next_line();
  for (std::string word = keyword(text); !word.empty(); word = keyword(text)) {
    if (word != "solid") text.fail("'solid' or the end of the file");
    text.next_line();  // the rest of the line is a name
    for (word = keyword(text); word == "facet"; word = keyword(text))
      mesh.triangles.push_back(read_facet(text, merger, mesh));
    if (word != "endsolid") text.fail("'facet' or 'endsolid'");
    text.next_line();
  }
  return mesh;
}

}  // namespace

TriangleMesh read_stl(const std::string& where, std::string_view bytes) {
  const bool long_enough = bytes.size() >= kHeader;
  const bool fits = long_enough &&
                    bytes.size() == kHeader + kFacet * std::uint64_t{read_uint32(bytes.data() + kHeader - 4)};
  const bool ascii = !fits && bytes.starts_with("solid") && bytes.find('\0') == std::string_view::npos;
  if (!ascii && !long_enough)
    throw InputError(where + ": " + std::to_string(bytes.size()) +
                     " bytes, expected 'solid' or the 84 bytes before the facets of a binary STL file");
  TriangleMesh mesh = ascii ? read_ascii(where, bytes) : read_binary(where, bytes);
  if (mesh.triangles.empty()) throw InputError(where + ": no facets, expected at least one");
  return mesh;
}

}  // namespace feder
