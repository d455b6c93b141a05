// A closed oriented surface: the sides of all triangles, sorted by their two vertices, come in pairs of
// opposite direction. Each pair joins the corners of its two triangles at both of its ends; the corners at
// one vertex are then one set, its fan, or the surface touches itself there (union-find, Tarjan 1975).
#include "engine/geometry/mesh_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "engine/check.h"
#include "engine/geometry/mesh_moments.h"

namespace feder {
namespace {

// A volume below this many roundings of area times coordinate is no volume.
constexpr double kFlat = 16.0 * std::numeric_limits<double>::epsilon();

using Triangles = std::vector<std::array<int, 3>>;

// From corner `corner` of a triangle to the next one.
struct Side {
  int low, high, triangle, corner;
  auto operator<=>(const Side&) const = default;
};

class Fans {
 public:
  explicit Fans(const Triangles& triangles) : triangles_(triangles), parent_(3 * triangles.size()) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  // The corners of both triangles at this vertex belong to one fan.
  void join(int vertex, int a, int b) { parent_[root(corner(vertex, a))] = root(corner(vertex, b)); }
  int root(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

 private:
  int corner(int vertex, int triangle) const {
    const std::array<int, 3>& t = triangles_[triangle];
    return 3 * triangle + (t[0] == vertex ? 0 : t[1] == vertex ? 1 : 2);
  }
  const Triangles& triangles_;
  std::vector<int> parent_;
};

void check_vertices(const std::string& where, const std::vector<Vector3d>& vertices) {
  for (std::size_t i = 0; i < vertices.size(); ++i)
    if (!vertices[i].allFinite())
      for (double x : vertices[i])
        require_finite(where + ", vertex " + std::to_string(i), "position", x, "m");
}

std::vector<Side> sorted_sides(const std::string& where, const TriangleMesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
    const std::array<int, 3>& t = mesh.triangles[k];
    for (int vertex : t)
      if (vertex < 0 || static_cast<std::size_t>(vertex) >= mesh.vertices.size())
        fail_input(where + ", triangle " + std::to_string(k), "vertex index", vertex, "",
                   "0 <= index < " + std::to_string(mesh.vertices.size()));
    if (repeats_an_index(t)) continue;
    for (int i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(t[i], t[(i + 1) % 3]);
      sides.push_back({low, high, static_cast<int>(k), i});
    }
  }
  std::sort(sides.begin(), sides.end());
  return sides;
}

// Every edge once each way; the corners that meet at its ends join their fans.
void check_edges(const std::string& where, const Triangles& triangles, const std::vector<Side>& sides,
                 Fans& fans) {
  auto upwards = [&](const Side& s) { return triangles[s.triangle][s.corner] == s.low; };
  for (std::size_t i = 0, next = 0; i < sides.size(); i = next) {
    const auto [low, high, triangle, corner] = sides[i];
    while (next < sides.size() && sides[next].low == low && sides[next].high == high) ++next;
    const std::size_t count = next - i;
    const bool opposite = count == 2 && upwards(sides[i]) != upwards(sides[i + 1]);
    if (opposite) {
      fans.join(low, triangle, sides[i + 1].triangle);
      fans.join(high, triangle, sides[i + 1].triangle);
      continue;
    }
    const std::string edge = where + ", edge (" + std::to_string(low) + ", " + std::to_string(high) +
                             ") of triangle " + std::to_string(triangle);
    const double triangle_count = static_cast<double>(count);
    if (count == 1) fail_input(edge, "number of triangles", 1, "", "2: the mesh is open here");
    if (count > 2)
      fail_input(edge, "number of triangles", triangle_count, "", "2: the mesh is not manifold here");
    fail_input(edge + " and triangle " + std::to_string(sides[i + 1].triangle), "triangles in one direction",
               triangle_count, "", "1 each way: the winding is inconsistent");
  }
}

[[noreturn]] void fail_fans(const std::string& where, const Triangles& triangles, Fans& fans, int vertex) {
  std::set<int> roots;
  for (std::size_t k = 0; k < triangles.size(); ++k)
    for (int i = 0; i < 3; ++i)
      if (triangles[k][i] == vertex && !repeats_an_index(triangles[k]))
        roots.insert(fans.root(3 * static_cast<int>(k) + i));
  fail_input(where + ", vertex " + std::to_string(vertex) + " of triangles " +
                 std::to_string(*roots.begin() / 3) + " and " + std::to_string(*roots.rbegin() / 3),
             "number of fans", static_cast<double>(roots.size()), "",
             "1: the mesh is not manifold here, parts touch in one point");
}

void check_fans(const std::string& where, const TriangleMesh& mesh, Fans& fans) {
  std::vector<int> fan_of(mesh.vertices.size(), -1);
  for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
    if (repeats_an_index(mesh.triangles[k])) continue;
    for (int i = 0; i < 3; ++i) {
      const int vertex = mesh.triangles[k][i], fan = fans.root(3 * static_cast<int>(k) + i);
      int& first = fan_of[vertex];
      if (first < 0) first = fan;
      if (first != fan) fail_fans(where, mesh.triangles, fans, vertex);
    }
  }
}

void check_volume(const std::string& where, const TriangleMesh& mesh) {
  const Eigen::AlignedBox3d bounds = used_bounds(mesh);
  const MeshMoments moments = mesh_moments(mesh, bounds.center());
  const double reach = std::max(bounds.min().cwiseAbs().maxCoeff(), bounds.max().cwiseAbs().maxCoeff());
  require_finite(where, "volume", moments.volume, "m^3");
  if (std::abs(moments.volume) <= kFlat * moments.area * reach)
    fail_input(where, "volume", moments.volume, "m^3", "a value > 0: the mesh is flat, nothing is inside");
  if (moments.volume < 0.0)
    fail_input(where, "volume", moments.volume, "m^3", "a value > 0: the mesh is inside out");
}

}  // namespace

void check_closed_mesh(const std::string& where, const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) fail_input(where, "number of triangles", 0, "", "a closed mesh");
  check_vertices(where, mesh.vertices);
  Fans fans(mesh.triangles);
  check_edges(where, mesh.triangles, sorted_sides(where, mesh), fans);
  check_fans(where, mesh, fans);
  check_volume(where, mesh);
}

}  // namespace feder
