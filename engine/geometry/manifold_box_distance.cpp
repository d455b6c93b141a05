// Nearest points of two boxes, or a box and a segment, that do not overlap: the smallest of the distances of
// every vertex from the other solid (coordinates limited to it) and of every two edges that cross between
// their ends. With the other vertices in about the same direction they hold parallel edges at both ends.
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/geometry/manifold_box_pair.h"

namespace feder {
namespace {

constexpr double kTouching = 1e-12;      // distance, relative to the sizes, that gives no direction
constexpr double kSameDirection = 0.95;  // cosine
constexpr double kCorner = 1e-4;         // as in manifold_boxes.cpp

/// Nearest points: on_a and on_a + apart.
struct Near {
  Vector3d on_a, apart;
  std::uint32_t feature;
};

Vector3d limited(const Vector3d& p, const Vector3d& half) {
  return p.cwiseMax(-half).cwiseMin(half);
}

bool at_corner(const Vector3d& p, const Vector3d& half) {
  return ((half - p.cwiseAbs()).array() <= kCorner * half.array()).all();
}

// A vertex of one solid at a vertex of the other is one pair, seen from either.
std::uint32_t vertex_pair(const Vector3d& on_a, const Vector3d& on_b, bool of_a, const BoxPair& pair) {
  const bool a = of_a || at_corner(on_a, pair.half_a), b = !of_a || at_corner(on_b, pair.half_b);
  return feature_pair(a ? vertex_feature(on_a) : 0, b ? vertex_feature(on_b) : 0);
}

template <class Visit>
void visit_vertices(const Vector3d& half, bool segment, Visit&& visit) {
  const int count = segment && half.z() == 0.0 ? 1 : 8;
  for (int k = 0; k < count; k += segment ? 4 : 1)
    visit(Vector3d(k & 1 ? half.x() : -half.x(), k & 2 ? half.y() : -half.y(), k & 4 ? half.z() : -half.z()));
}

template <class Visit>
void visit_edges(const Vector3d& half, bool segment, Visit&& visit) {
  for (int axis = segment ? 2 : 0; axis < 3; ++axis)
    for (int k = 0; k < (segment ? 1 : 4); ++k) {
      Vector3d middle = Vector3d::Zero();
      middle[(axis + 1) % 3] = k & 1 ? half[(axis + 1) % 3] : -half[(axis + 1) % 3];
      middle[(axis + 2) % 3] = k & 2 ? half[(axis + 2) % 3] : -half[(axis + 2) % 3];
      visit(axis, middle);
    }
}

template <class Visit>
void visit_near_vertices(const BoxPair& pair, Visit&& visit) {
  visit_vertices(pair.half_b, pair.segment(), [&](const Vector3d& corner) {
    const Vector3d at = pair.apart + pair.turn * corner, on_a = limited(at, pair.half_a);
    visit(Near{on_a, at - on_a, vertex_pair(on_a, corner, false, pair)});
  });
  visit_vertices(pair.half_a, false, [&](const Vector3d& corner) {
    const Vector3d at = pair.turn.transpose() * (corner - pair.apart), on_b = limited(at, pair.half_b);
    visit(Near{corner, pair.turn * (on_b - at), vertex_pair(corner, on_b, true, pair)});
  });
}

// The nearest two edges that cross between their ends, if nearer than `best`.
void find_crossing(const BoxPair& pair, Near& best) {
  visit_edges(pair.half_a, false, [&](int i, const Vector3d& middle_a) {
    visit_edges(pair.half_b, pair.segment(), [&](int j, const Vector3d& middle_b) {
      const Vector3d along = pair.turn.col(j), w = pair.apart + pair.turn * middle_b - middle_a;
      const double d = along[i], sine_squared = along.squaredNorm() - d * d;
      if (!(sine_squared > 1e-16)) return;
      const double s = (w[i] - d * along.dot(w)) / sine_squared, t = d * s - along.dot(w);
      if (!(std::abs(s) < pair.half_a[i] && std::abs(t) < pair.half_b[j])) return;
      Near near{middle_a, w + t * along, feature_pair(edge_feature(i, middle_a), edge_feature(j, middle_b))};
      near.on_a[i] = s;
      near.apart[i] -= s;
      if (near.apart.squaredNorm() < best.apart.squaredNorm()) best = near;
    });
  });
}

}  // namespace

void find_closest_box_points(const BoxPair& pair, double limit, const Vector3d& normal, double separation,
                             BoxContacts& out) {
  Near best{Vector3d::Zero(), Vector3d::Constant(std::numeric_limits<double>::infinity()), 0};
  visit_near_vertices(pair, [&](const Near& near) {
    if (near.apart.squaredNorm() < best.apart.squaredNorm()) best = near;
  });
  find_crossing(pair, best);
  const double distance = best.apart.norm();
  if (distance <= kTouching * pair.scale) {
    out.add({best.on_a, normal, separation, best.feature});
    return;
  }
  const Vector3d toward = best.apart / distance;
  const auto add = [&](const Near& near) {
    const double gap = near.apart.norm();
    if (gap <= limit && near.apart.dot(toward) >= kSameDirection * gap && gap > 0.0)
      out.add({near.on_a, near.apart / gap, gap, near.feature});
  };
  visit_near_vertices(pair, add);
  add(best);
}

}  // namespace feder
