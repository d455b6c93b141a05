// Branch and bound: of two children the nearer is entered first, and none whose volume is no nearer than the
// best found so far. Lower bounds are those of bvh_volumes.h.
#include <array>
#include <cmath>
#include <limits>

#include "engine/check.h"
#include "engine/geometry/bvh_queries.h"
#include "engine/geometry/bvh_volumes.h"

namespace feder {
namespace {

// Both children onto the stack, the nearer on top.
template <class Stack, class Entry>
void push_nearer_last(Stack& stack, int& top, Entry first, Entry second) {
  if (second.bound < first.bound) std::swap(first, second);
  stack[top++] = second;
  stack[top++] = first;
}

}  // namespace

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
  const auto enter = [&](std::int32_t node) { return Entry{node, distance_squared(nodes[node].volume, p)}; };
  std::array<Entry, kBvhDepth> stack{enter(0)};
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
    if (node.count == 0) push_nearer_last(stack, top, enter(node.first), enter(node.first + 1));
  }
  return best;
}

template <class Volume>
std::optional<MeshDistance> closest_points(const Bvh<Volume>& a, const Pose& pose_a, const Bvh<Volume>& b,
                                           const Pose& pose_b) {
  if (a.size() == 0 || b.size() == 0) return std::nullopt;
  const auto &nodes_a = a.nodes(), &nodes_b = b.nodes();
  const Relative frame = relative(pose_a, pose_b, reach_of(nodes_a[0].volume) + reach_of(nodes_b[0].volume));
  struct Entry {
    std::int32_t a, b;
    double bound;
  };
  const auto enter = [&](std::int32_t x, std::int32_t y) {
    return Entry{x, y, distance_squared(nodes_a[x].volume, nodes_b[y].volume, frame)};
  };
  ClosestPair best{Vector3d::Zero(), Vector3d::Zero(), std::numeric_limits<double>::infinity()};
  TrianglePair triangles;
  std::array<Entry, 2 * kBvhDepth> stack{enter(0, 0)};
  for (int top = 1; top > 0;) {
    const Entry entry = stack[--top];
    if (entry.bound >= best.distance_squared) continue;
    const BvhNode<Volume>&x = nodes_a[entry.a], &y = nodes_b[entry.b];
    for (int j = y.first; x.count > 0 && j < y.first + y.count; ++j) {
      const Triangle other = frame(b.corners(j));
      for (int i = x.first; i < x.first + x.count; ++i) {
        const ClosestPair here = closest_points(a.corners(i), other);
        if (here.distance_squared >= best.distance_squared) continue;
        best = here;
        triangles = {a.triangle(i), b.triangle(j)};
      }
    }
    if (x.count > 0 && y.count > 0) continue;
    if (y.count > 0 || (x.count == 0 && size_of(x.volume) >= size_of(y.volume)))
      push_nearer_last(stack, top, enter(x.first, entry.b), enter(x.first + 1, entry.b));
    else
      push_nearer_last(stack, top, enter(entry.a, y.first), enter(entry.a, y.first + 1));
  }
  return MeshDistance{pose_a.rotation * best.a + pose_a.position, pose_a.rotation * best.b + pose_a.position,
                      std::sqrt(best.distance_squared), triangles};
}

template <class Volume>
std::optional<RayHit> first_hit(const Bvh<Volume>& mesh, const Vector3d& origin, const Vector3d& direction,
                                double limit) {
  FEDER_CHECK(origin.allFinite() && direction.allFinite() && limit >= 0.0,
              "the ray is not finite, or its limit not >= 0");
  const auto& nodes = mesh.nodes();
  std::optional<RayHit> best;
  if (nodes.empty()) return best;
  const double slack = ray_slack(reach_of(nodes[0].volume), origin);
  struct Entry {
    std::int32_t node;
    double bound;
  };
  const auto enter = [&](std::int32_t node) {
    return Entry{node, ray_entry(nodes[node].volume, origin, direction, slack)};
  };
  std::array<Entry, kBvhDepth> stack{enter(0)};
  for (int top = 1; top > 0;) {
    const Entry entry = stack[--top];
    if (entry.bound > limit) continue;
    const BvhNode<Volume>& node = nodes[entry.node];
    for (int k = node.first; k < node.first + node.count; ++k) {
      const std::optional<double> t = ray_hit(mesh.corners(k), origin, direction, limit);
      if (!t || (best && *t == limit)) continue;
      limit = *t;
      best = {limit, mesh.triangle(k)};
    }
    if (node.count == 0) push_nearer_last(stack, top, enter(node.first), enter(node.first + 1));
  }
  return best;
}

template std::optional<MeshPoint> closest_point(const Bvh<Sphere>&, const Vector3d&, double);
template std::optional<MeshPoint> closest_point(const Bvh<Aabb>&, const Vector3d&, double);
template std::optional<MeshPoint> closest_point(const Bvh<Obb>&, const Vector3d&, double);
template std::optional<MeshDistance> closest_points(const Bvh<Sphere>&, const Pose&, const Bvh<Sphere>&,
                                                    const Pose&);
template std::optional<MeshDistance> closest_points(const Bvh<Aabb>&, const Pose&, const Bvh<Aabb>&,
                                                    const Pose&);
template std::optional<MeshDistance> closest_points(const Bvh<Obb>&, const Pose&, const Bvh<Obb>&,
                                                    const Pose&);
template std::optional<RayHit> first_hit(const Bvh<Sphere>&, const Vector3d&, const Vector3d&, double);
template std::optional<RayHit> first_hit(const Bvh<Aabb>&, const Vector3d&, const Vector3d&, double);
template std::optional<RayHit> first_hit(const Bvh<Obb>&, const Vector3d&, const Vector3d&, double);

}  // namespace feder
