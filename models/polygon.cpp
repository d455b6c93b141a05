// With the vector area n = 1/2 sum x_i x x_(i+1), a corner (a, b, c) is convex where (b - a) x (c - b) . n >
// 0. A polygon whose fan around its first vertex has no triangle against n is cut that way; any other by
// ears: convex corners whose triangle holds no other vertex (Meisters, Polygons have ears, 1975).
#include "models/polygon.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace feder {
namespace {

struct Cutter {
  const std::vector<Vector3d>& vertices;
  Vector3d normal = Vector3d::Zero();

  const Vector3d& at(int i) const { return vertices[static_cast<std::size_t>(i)]; }
  double area(int a, int b, int c) const { return (at(b) - at(a)).cross(at(c) - at(b)).dot(normal); }

  /// Inside or on the border; vertices at the corners themselves do not count.
  bool holds(int a, int b, int c, int p) const {
    if (at(p) == at(a) || at(p) == at(b) || at(p) == at(c)) return false;
    return area(a, b, p) >= 0.0 && area(b, c, p) >= 0.0 && area(c, a, p) >= 0.0;
  }

  bool is_ear(const std::vector<int>& ring, std::size_t i, bool flat) const {
    const std::size_t n = ring.size();
    const int a = ring[(i + n - 1) % n], b = ring[i], c = ring[(i + 1) % n];
    const double size = area(a, b, c);
    if (flat) return size == 0.0;
    return size > 0.0 && std::none_of(ring.begin(), ring.end(),
                                      [&](int p) { return p != a && p != b && p != c && holds(a, b, c, p); });
  }
};

}  // namespace

bool triangulate(const std::vector<Vector3d>& vertices, const std::vector<int>& polygon,
                 std::vector<std::array<int, 3>>& triangles) {
  Cutter cutter{vertices};
  const Vector3d origin = cutter.at(polygon[0]);
  bool straight = true;  // all corners on one line
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i) {
    const Vector3d part = (cutter.at(polygon[i]) - origin).cross(cutter.at(polygon[i + 1]) - origin);
    cutter.normal += part;
    straight = straight && part.isZero(0.0);
  }
  if (!straight && cutter.normal.isZero(0.0)) return false;

  bool fan = true;
  for (std::size_t i = 1; i + 1 < polygon.size() && fan; ++i)
    fan = cutter.area(polygon[0], polygon[i], polygon[i + 1]) >= 0.0;
  if (fan) {
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
      triangles.push_back({polygon[0], polygon[i], polygon[i + 1]});
    return true;
  }

  std::vector<int> ring = polygon;
  while (ring.size() > 3) {
    std::size_t ear = ring.size();
    for (const bool flat : {false, true})
      for (std::size_t i = 0; i < ring.size() && ear == ring.size(); ++i)
        if (cutter.is_ear(ring, i, flat)) ear = i;
    const std::size_t n = ring.size();
    if (ear == n) return false;
    triangles.push_back({ring[(ear + n - 1) % n], ring[ear], ring[(ear + 1) % n]});
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  triangles.push_back({ring[0], ring[1], ring[2]});
  return cutter.area(ring[0], ring[1], ring[2]) >= 0.0;
}

}  // namespace feder
