// Branch and bound: of two children the nearer is entered first, and none whose volume is no nearer than the
// best point so far.
#include <array>
#include <cmath>
#include <limits>

#include "engine/check.h"
#include "engine/geometry/bvh_queries.h"
#include "engine/geometry/bvh_volumes.h"

namespace feder {

template <class Volume>
std::optional<MeshPoint> closest_point(const Bvh<Volume>& mesh, const Vector3d& p, double margin) {
  FEDER_CHECK(p.allFinite() && margin >= 0.0, "the point is not finite, or the margin not >= 0");
  const auto& nodes = mesh.nodes();
  std::optional<MeshPoint> best;
  if (nodes.empty()) return best;
  struct Entry {
    std::int32_t node;
    double bound;
  };
  std::array<Entry, kBvhDepth> stack;
  stack[0] = {0, distance_squared(nodes[0].volume, p)};
  double limit = margin * margin;
  for (int top = 1; top > 0;) {
    const Entry entry = stack[--top];
    if (entry.bound > limit) continue;
    const BvhNode<Volume>& node = nodes[entry.node];
    for (int k = node.first; k < node.first + node.count; ++k) {
      const TrianglePoint here = closest_point(mesh.corners(k), p);
      if (here.distance_squared > limit || (best && here.distance_squared == limit)) continue;
      limit = here.distance_squared;
      best = {here.point, limit, mesh.triangle(k), here.feature, here.index};
    }
    if (node.count > 0) continue;
    Entry near{node.first, distance_squared(nodes[node.first].volume, p)};
    Entry far{node.first + 1, distance_squared(nodes[node.first + 1].volume, p)};
    if (far.bound < near.bound) std::swap(near, far);
    stack[top++] = far;
    stack[top++] = near;
  }
  return best;
}

template std::optional<MeshPoint> closest_point(const Bvh<Sphere>&, const Vector3d&, double);
template std::optional<MeshPoint> closest_point(const Bvh<Aabb>&, const Vector3d&, double);
template std::optional<MeshPoint> closest_point(const Bvh<Obb>&, const Vector3d&, double);

}  // namespace feder
