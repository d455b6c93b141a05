// Bodies of revolution as rings of 4 k vertices, k = 0 ... n ... 0: a ring at polar angle (pi/2) k/n of a
// sphere has sides of about the distance to the next ring, pi/(2 n), wherever it lies.
#include "engine/geometry/mesh_generators.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "engine/check.h"

namespace feder {
namespace {

using std::numbers::pi;
// 4 n^2 + 4 n + 2 vertices, 3 (8 n^2 + 8 n) corners: all below 2^31.
constexpr int kMostSegments = 9000;

void check_count(const std::string& where, const std::string& name, int count, int least, int most) {
  if (count < least || count > most)
    fail_input(where, name, count, "", "from " + std::to_string(least) + " to " + std::to_string(most));
}

struct Ring {
  double radius, z;  // [m]
  int quarter;       // a quarter of the number of vertices; 0: one vertex, a pole
};

// Vertex i of a ring, counted round and round; `first` is that of vertex 0.
int vertex_of(int first, const Ring& ring, int i) {
  return ring.quarter == 0 ? first : first + i % (4 * ring.quarter);
}

// The strip between two rings, a below b, quarter by quarter: the next triangle has its base on the ring that
// is behind.
void join(const Ring& a, int first_a, const Ring& b, int first_b, TriangleMesh& mesh) {
  for (int q = 0; q < 4; ++q) {
    int i = 0, j = 0;
    while (i < a.quarter || j < b.quarter) {
      const int va = vertex_of(first_a, a, q * a.quarter + i), vb = vertex_of(first_b, b, q * b.quarter + j);
      const bool on_a =
          i < a.quarter && (j >= b.quarter || (2 * i + 1) * b.quarter <= (2 * j + 1) * a.quarter);
      if (on_a)
        mesh.triangles.push_back({va, vertex_of(first_a, a, q * a.quarter + ++i), vb});
      else
        mesh.triangles.push_back({va, vertex_of(first_b, b, q * b.quarter + j + 1), vb}), ++j;
    }
  }
}

// From the lower pole to the upper one.
TriangleMesh revolved(const std::vector<Ring>& rings) {
  TriangleMesh mesh;
  int first_below = 0;
  for (std::size_t k = 0; k < rings.size(); ++k) {
    const Ring& ring = rings[k];
    const int first = static_cast<int>(mesh.vertices.size()), count = 4 * ring.quarter;
    if (count == 0) mesh.vertices.emplace_back(0.0, 0.0, ring.z);
    for (int i = 0; i < count; ++i) {
      const double angle = 2.0 * pi * i / count;
      mesh.vertices.emplace_back(ring.radius * std::cos(angle), ring.radius * std::sin(angle), ring.z);
    }
    if (k > 0) join(rings[k - 1], first_below, ring, first, mesh);
    first_below = first;
  }
  return mesh;
}

// The lower half from its pole to its widest ring, and the same turned over.
TriangleMesh revolved_symmetric(std::vector<Ring> lower, bool shared_widest) {
  const std::size_t count = lower.size();
  for (std::size_t k = shared_widest ? count - 1 : count; k-- > 0;)
    lower.push_back({lower[k].radius, -lower[k].z, lower[k].quarter});
  return revolved(lower);
}

std::vector<Ring> lower_hemisphere(double radius, double equator, int n) {
  std::vector<Ring> rings;
  for (int k = 0; k <= n; ++k) {
    const double angle = 0.5 * pi * k / n;
    rings.push_back({radius * std::sin(angle), k == n ? equator : equator - radius * std::cos(angle), k});
  }
  return rings;
}

}  // namespace

TriangleMesh box_mesh(const std::string& where, const Vector3d& edges) {
  for (int c = 0; c < 3; ++c) require_positive(where, std::string("edge length ") + "xyz"[c], edges[c], "m");
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.push_back(0.5 *
                            edges.cwiseProduct(Vector3d(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  mesh.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  return mesh;
}

TriangleMesh sphere_mesh(const std::string& where, double radius, int n) {
  require_positive(where, "radius", radius, "m");
  check_count(where, "segments of a quarter circle", n, 1, kMostSegments);
  return revolved_symmetric(lower_hemisphere(radius, 0.0, n), true);
}

TriangleMesh cylinder_mesh(const std::string& where, double radius, double height, int n) {
  require_positive(where, "radius", radius, "m");
  require_positive(where, "height", height, "m");
  check_count(where, "segments of a quarter circle", n, 1, kMostSegments);
  std::vector<Ring> disc;
  for (int k = 0; k <= n; ++k) disc.push_back({radius * k / n, -0.5 * height, k});
  return revolved_symmetric(disc, false);
}

TriangleMesh capsule_mesh(const std::string& where, double radius, double half_length, int n) {
  require_positive(where, "radius", radius, "m");
  require_positive(where, "half length", half_length, "m");
  check_count(where, "segments of a quarter circle", n, 1, kMostSegments);
  return revolved_symmetric(lower_hemisphere(radius, -half_length, n), false);
}

TriangleMesh torus_mesh(const std::string& where, double major, double minor, int around, int across) {
  require_positive(where, "circle radius", major, "m");
  require_positive(where, "tube radius", minor, "m");
  if (!(minor < major)) fail_input(where, "tube radius", minor, "m", "less than the circle radius");
  constexpr int kMostCorners = std::numeric_limits<int>::max() / 6;
  check_count(where, "segments around", around, 3, kMostCorners / 3);
  check_count(where, "segments across", across, 3, kMostCorners / around);

  TriangleMesh mesh;
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double turn = 2.0 * pi * i / around, tilt = 2.0 * pi * j / across;
      const double distance = major + minor * std::cos(tilt);
      mesh.vertices.emplace_back(distance * std::cos(turn), distance * std::sin(turn),
                                 minor * std::sin(tilt));
      const int next = (i + 1) % around, a = i * across + j, b = next * across + j,
                c = next * across + (j + 1) % across, d = i * across + (j + 1) % across;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  return mesh;
}

}  // namespace feder
