#include "models/mesh_io.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>

#include "engine/check.h"
#include "models/mesh_text.h"
#include "models/parameters.h"
#include "models/polygon.h"

namespace feder {
namespace {

constexpr std::size_t kMostCorners = 1000;

const std::vector<std::string> kSkipped = {
    "vt",     "vn", "vp",     "g",          "o",         "s",   "mg",    "mtllib",   "l",       "usemtl",
    "usemap", "p",  "maplib", "shadow_obj", "trace_obj", "lod", "bevel", "c_interp", "d_interp"};

/// Faces wait until all vertices are known.
struct Faces {
  std::vector<std::int64_t> corners;  // from 0
  std::vector<std::size_t> first;     // into corners
  std::vector<int> line;
};

Vector3d read_vertex(MeshText& text) {
  Vector3d x;
  for (int axis = 0; axis < 3; ++axis) x[axis] = text.number("a coordinate");
  std::array<double, 3> more{};
  std::size_t count = 0;
  for (; text.more_on_line() && count < 3; ++count) more[count] = text.number("a weight or a colour");
  if (text.more_on_line() || count == 2) text.fail("3 coordinates, a weight of 1 or a colour of 3 numbers");
  if (count == 1 && more[0] != 1.0) text.fail("a weight of 1 after 3 coordinates");
  return x;
}

/// "7", "7/1", "7//3", "7/1/3", "-1": the vertex, from 0.
std::int64_t read_corner(MeshText& text, std::size_t vertices) {
  constexpr const char* kExpected = "a vertex index that is not 0, for example 7, 7/1, 7//3 or -1";
  std::string_view word = text.word();
  std::int64_t vertex = 0;
  for (int part = 0; part < 3; ++part) {
    std::int64_t index = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
    const bool empty = end == word.data();
    if ((empty && part != 1) || (!empty && (error != std::errc() || index == 0))) text.fail(kExpected);
    if (part == 0) vertex = index;
    word.remove_prefix(static_cast<std::size_t>(end - word.data()));
    if (word.empty()) break;
    if (word[0] != '/' || part == 2) text.fail(kExpected);
    word.remove_prefix(1);
    if (word.empty()) text.fail(kExpected);
  }
  if (vertex > 0) return vertex - 1;
  if (static_cast<std::uint64_t>(-(vertex + 1)) >= vertices)
    text.fail("a vertex counted back from here, of " + std::to_string(vertices));
  return static_cast<std::int64_t>(vertices) + vertex;
}

void read_face(MeshText& text, std::size_t vertices, Faces& faces) {
  faces.first.push_back(faces.corners.size());
  faces.line.push_back(text.line());
  std::size_t count = 0;
  for (; text.more_on_line(); ++count) faces.corners.push_back(read_corner(text, vertices));
  if (count < 3 || count > kMostCorners)
    text.fail_line("face with " + std::to_string(count) + " vertices, expected 3 to " +
                   std::to_string(kMostCorners));
}

void cut_faces(const MeshText& text, const Faces& faces, TriangleMesh& mesh) {
  std::vector<int> polygon;
  for (std::size_t face = 0; face < faces.first.size(); ++face) {
    const std::size_t end = face + 1 < faces.first.size() ? faces.first[face + 1] : faces.corners.size();
    polygon.clear();
    for (std::size_t i = faces.first[face]; i < end; ++i) {
      if (faces.corners[i] >= static_cast<std::int64_t>(mesh.vertices.size()))
        text.fail_at(faces.line[face], "vertex index = " + std::to_string(faces.corners[i] + 1) +
                                           ", expected 1 to " + std::to_string(mesh.vertices.size()));
      polygon.push_back(static_cast<int>(faces.corners[i]));
    }
    if (!triangulate(mesh.vertices, polygon, mesh.triangles))
      text.fail_at(faces.line[face], "face of " + std::to_string(polygon.size()) +
                                         " vertices, expected a polygon that does not cross itself");
  }
}

}  // namespace

TriangleMesh read_obj(const std::string& where, std::string_view content) {
  MeshText text(where, content);
  TriangleMesh mesh;
  Faces faces;
  while (text.next_line()) {
    if (!text.more_on_line()) continue;
    const std::string keyword(text.word());
    if (keyword == "v") {
      mesh.vertices.push_back(read_vertex(text));
    } else if (keyword == "f") {
      read_face(text, mesh.vertices.size(), faces);
    } else if (std::find(kSkipped.begin(), kSkipped.end(), keyword) == kSkipped.end()) {
      text.fail("v, f or another keyword of an OBJ file of polygons");
    }
  }
  cut_faces(text, faces, mesh);
  if (mesh.triangles.empty()) throw InputError(where + ": no faces, expected at least one");
  return mesh;
}

TriangleMesh read_mesh(const std::filesystem::path& file) {
  const std::string where = file.string();
  std::string kind = file.extension().string();
  for (char& c : kind)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  if (kind != ".obj" && kind != ".stl") throw InputError(where + ": expected a mesh in a file .obj or .stl");
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) throw InputError(where + ": no such file");
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) throw InputError(where + ": cannot be read: " + error.message());
  if (size > kLargestMeshFile)
    fail_input(where, "size", static_cast<double>(size), "bytes", "at most 256 MiB");
  std::string content(static_cast<std::size_t>(size), '\0');
  std::ifstream in(file, std::ios::binary);
  if (!in.read(content.data(), static_cast<std::streamsize>(size)))
    throw InputError(where + ": cannot be read to its end");
  return kind == ".obj" ? read_obj(where, content) : read_stl(where, content);
}

}  // namespace feder
