// Contacts of a box with a box, or with the segment inside a capsule (a box with two half edges 0).
// Separation along a unit axis n, with c = c_b - c_a:  s(n) = |n.c| - sum_i h_ai |n.e_ai| - sum_j h_bj
// |n.e_bj|. Its largest value over the face normals and the products of edges is, for solids that overlap,
// minus the smallest translation that parts them (Gottschalk, Lin, Manocha, OBBTree, 1996), and that axis is
// the normal. Points: the faces of both that look along the normal, projected along it, overlap in a convex
// polygon; its vertices are vertices of one face inside the other or crossings of two edges. Neither face is
// the reference. Far from both face normals only the two edges touch. Where the polygon does not reach s > 0
// the solids are nearest at a vertex or at parallel edges: manifold_box_distance.cpp.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/geometry/manifold_box_pair.h"

namespace feder {
namespace {

constexpr double kTie = 1e-12;           // separations that close, relative to the sizes, are the same
constexpr double kParallelEdges = 1e-8;  // sine of the angle below which edges make no axis
constexpr double kCloser = 1e-10;  // relative to the sizes: edges of both that lie on each other cross where
                                   // one vertex hangs over; it counts if it is closer by that
constexpr double kFaceNormal = 0.95;  // cosine of the angle to a face normal up to which the face touches
constexpr double kCorner = 1e-4;      // of the smallest half edge: as close as that to a vertex is the vertex

struct Axis {
  Vector3d normal;  // in the axes of a, from a to b
  double separation;
  int edge_a = -1, edge_b = -1;  // directions of the edges, or -1 for a face normal
};

/// A face: its axis, its side (+-1), and the other two axes.
struct Face {
  int axis, u, v;
  double side;

  explicit Face(const Vector3d& outward) {
    outward.cwiseAbs().maxCoeff(&axis);
    u = (axis + 1) % 3, v = (axis + 2) % 3;
    side = outward[axis] < 0.0 ? -1.0 : 1.0;
  }
  Vector3d corner(int k, const Vector3d& half) const {
    Vector3d out;
    out[axis] = side * half[axis];
    out[u] = k == 0 || k == 3 ? half[u] : -half[u];
    out[v] = k < 2 ? half[v] : -half[v];
    return out;
  }
};

class Clip {
 public:
  Clip(const BoxPair& pair, const Vector3d& normal, double tolerance)
      : pair_(pair),
        normal_(normal),
        normal_b_(pair.turn.transpose() * normal),
        tolerance_(tolerance),
        face_(normal),
        face_b_(-normal_b_) {
    corner_ = kCorner * std::min({pair.half_a[face_.u], pair.half_a[face_.v],
                                  pair.segment() ? pair.half_b.z() : pair.half_b.minCoeff()});
  }
  void run(BoxContacts& out) {
    project_b();
    if (!pair_.segment()) add_vertices_of_a(out);
    for (int k = 0; k < corners_; ++k) {
      const Projected& x = projected_[k];
      if (std::abs(x.on_a[face_.u]) <= pair_.half_a[face_.u] + tolerance_ &&
          std::abs(x.on_a[face_.v]) <= pair_.half_a[face_.v] + tolerance_)
        add(out, x.on_a, x.gap, feature_pair(0, vertex_feature(x.corner)));
    }
    const int edges = pair_.segment() ? 1 : 4;
    for (int k = 0; k < edges; ++k) add_crossings(out, projected_[k], projected_[(k + 1) % corners_]);
    if (along_.gap < out.least() - kCloser * pair_.scale) add(out, along_.on_a, along_.gap, along_.feature);
  }

 private:
  struct Projected {
    Vector3d corner;  // of b, in its axes
    Vector3d on_a;    // along the normal, on the plane of the face of a
    double gap;
  };

  void project_b() {
    corners_ = !pair_.segment() ? 4 : pair_.half_b.z() > 0.0 ? 2 : 1;
    for (int k = 0; k < corners_; ++k) {
      Projected& x = projected_[k];
      x.corner = pair_.segment() ? Vector3d(0, 0, k ? pair_.half_b.z() : -pair_.half_b.z())
                                 : face_b_.corner(k, pair_.half_b);
      const Vector3d at = pair_.apart + pair_.turn * x.corner;
      x.gap = (at[face_.axis] - face_.side * pair_.half_a[face_.axis]) / normal_[face_.axis];
      x.on_a = at - x.gap * normal_;
    }
  }

  void add_vertices_of_a(BoxContacts& out) const {
    for (int k = 0; k < 4; ++k) {
      const Vector3d corner = face_.corner(k, pair_.half_a);
      const Vector3d at = pair_.turn.transpose() * (corner - pair_.apart);
      const double gap =
          (face_b_.side * pair_.half_b[face_b_.axis] - at[face_b_.axis]) / normal_b_[face_b_.axis];
      const Vector3d on_b = at + gap * normal_b_;
      if (std::abs(on_b[face_b_.u]) <= pair_.half_b[face_b_.u] + tolerance_ &&
          std::abs(on_b[face_b_.v]) <= pair_.half_b[face_b_.v] + tolerance_)
        out.add({corner, normal_, gap, feature_pair(vertex_feature(corner), 0)});
    }
  }

  // An edge of b from x to y with the four edges of the face of a.
  void add_crossings(BoxContacts& out, const Projected& x, const Projected& y) {
    for (int line = 0; line < 4; ++line) {
      const int across = line < 2 ? face_.u : face_.v, along = line < 2 ? face_.v : face_.u;
      const double side = line % 2 ? 1.0 : -1.0, half = pair_.half_a[across];
      const double from = side * x.on_a[across] - half, to = side * y.on_a[across] - half;
      if ((from < 0.0) == (to < 0.0)) continue;
      const bool along_line = std::abs(from) <= corner_ && std::abs(to) <= corner_;
      const double part = from / (from - to);
      Vector3d on_a = x.on_a + part * (y.on_a - x.on_a);
      on_a[across] = side * half;
      if (std::abs(on_a[along]) > pair_.half_a[along] + tolerance_) continue;
      const double length = (y.corner - x.corner).norm();
      const std::uint32_t of_b = part * length <= corner_           ? vertex_feature(x.corner)
                                 : (1.0 - part) * length <= corner_ ? vertex_feature(y.corner)
                                                                    : 0;
      const std::uint32_t feature =
          of_b ? feature_pair(0, of_b)
               : feature_pair(edge_feature(along, on_a), edge_feature(x.corner, y.corner));
      const double gap = x.gap + part * (y.gap - x.gap);
      if (!along_line)
        add(out, on_a, gap, feature);
      else if (gap < along_.gap)
        along_ = {on_a, normal_, gap, feature};
    }
  }

  // A point on the face of a; near to a vertex of a it is that vertex.
  void add(BoxContacts& out, const Vector3d& on_a, double gap, std::uint32_t feature) const {
    const bool vertex = std::abs(std::abs(on_a[face_.u]) - pair_.half_a[face_.u]) <= corner_ &&
                        std::abs(std::abs(on_a[face_.v]) - pair_.half_a[face_.v]) <= corner_;
    out.add({on_a, normal_, gap, vertex ? feature_pair(vertex_feature(on_a), 0) : feature});
  }

  const BoxPair& pair_;
  const Vector3d normal_, normal_b_;
  const double tolerance_;
  const Face face_, face_b_;
  double corner_ = 0.0;
  int corners_ = 0;
  std::array<Projected, 4> projected_;
  BoxContact along_{{}, {}, std::numeric_limits<double>::infinity(), 0};  // where edges lie on each other
};

// The axis of largest separation; false once one separation exceeds the limit.
bool separate(const BoxPair& pair, double limit, Axis& best) {
  const Matrix3d &turn = pair.turn, size = turn.cwiseAbs();
  const double tie = kTie * pair.scale;
  const Vector3d apart_b = turn.transpose() * pair.apart;
  int best_i = -1, best_j = -1;
  best.separation = -std::numeric_limits<double>::infinity();
  const auto try_axis = [&](double separation, int i, int j) {
    if (separation > best.separation + tie) best.separation = separation, best_i = i, best_j = j;
    return separation <= limit;
  };
  // face normals of a, then of b
  const Vector3d across_a = pair.apart.cwiseAbs() - pair.half_a - size * pair.half_b;
  for (int i = 0; i < 3; ++i)
    if (!try_axis(across_a[i], i, -1)) return false;
  const Vector3d across_b = apart_b.cwiseAbs() - pair.half_b - size.transpose() * pair.half_a;
  for (int j = pair.segment() ? 3 : 0; j < 3; ++j)
    if (!try_axis(across_b[j], -1, j)) return false;
  // products of edges: e_i x e_j has the coordinates -turn(v, j), turn(u, j) along u, v, the axes after i
  for (int i = 0; i < 3; ++i)
    for (int j = pair.segment() ? 2 : 0; j < 3; ++j) {
      const int u = (i + 1) % 3, v = (i + 2) % 3, k = (j + 1) % 3, l = (j + 2) % 3;
      const double sine = std::sqrt(turn(u, j) * turn(u, j) + turn(v, j) * turn(v, j));
      if (sine < kParallelEdges) continue;
      const double centres = std::abs(pair.apart[v] * turn(u, j) - pair.apart[u] * turn(v, j));
      const double reach = pair.half_a[u] * size(v, j) + pair.half_a[v] * size(u, j) +
                           pair.half_b[k] * size(i, l) + pair.half_b[l] * size(i, k);
      if (!try_axis((centres - reach) / sine, i, j)) return false;
    }
  best.normal = best_j < 0   ? Vector3d(Vector3d::Unit(best_i))
                : best_i < 0 ? Vector3d(turn.col(best_j))
                             : Vector3d(Vector3d::Unit(best_i).cross(turn.col(best_j)).normalized());
  if (pair.apart.dot(best.normal) < 0.0) best.normal = -best.normal;
  if (best_i >= 0 && best_j >= 0) best.edge_a = best_i, best.edge_b = best_j;
  return true;
}

// The crossing of the two edges that touch along the axis; false if it is not inside both.
bool add_edge_crossing(const BoxPair& pair, const Axis& axis, double tolerance, BoxContacts& out) {
  const Vector3d normal_b = pair.turn.transpose() * axis.normal;
  Vector3d at_a, at_b;  // middles of the edges, each in the axes of its box
  for (int i = 0; i < 3; ++i) {
    at_a[i] = i == axis.edge_a ? 0.0 : std::copysign(pair.half_a[i], axis.normal[i]);
    at_b[i] = i == axis.edge_b ? 0.0 : -std::copysign(pair.half_b[i], normal_b[i]);
  }
  const Vector3d along_b = pair.turn.col(axis.edge_b), w = pair.apart + pair.turn * at_b - at_a;
  const double d = along_b[axis.edge_a], half_a = pair.half_a[axis.edge_a], half_b = pair.half_b[axis.edge_b];
  const double s = (w[axis.edge_a] - d * along_b.dot(w)) / (1.0 - d * d), t = d * s - along_b.dot(w);
  const bool inside = std::abs(s) <= half_a + tolerance && std::abs(t) <= half_b + tolerance;
  if (!inside && axis.separation > 0.0) return false;
  const std::uint32_t of_a = edge_feature(axis.edge_a, at_a), of_b = edge_feature(axis.edge_b, at_b);
  at_a[axis.edge_a] = std::clamp(s, -half_a, half_a);
  out.add({at_a, axis.normal, axis.separation, feature_pair(of_a, of_b)});
  return true;
}

}  // namespace

std::uint32_t vertex_feature(const Vector3d& corner) {
  return 1u + (corner.x() > 0.0 ? 1u : 0u) + (corner.y() > 0.0 ? 2u : 0u) + (corner.z() > 0.0 ? 4u : 0u);
}

std::uint32_t edge_feature(int axis, const Vector3d& point) {
  const bool first = point[(axis + 1) % 3] > 0.0, second = point[(axis + 2) % 3] > 0.0;
  return 16u + 4u * static_cast<std::uint32_t>(axis) + (first ? 1u : 0u) + (second ? 2u : 0u);
}

std::uint32_t edge_feature(const Vector3d& from, const Vector3d& to) {
  int axis;
  (to - from).cwiseAbs().maxCoeff(&axis);
  return edge_feature(axis, from);
}

BoxPair::BoxPair(const Vector3d& a, const Pose& pose_a, const Vector3d& b, const Pose& pose_b)
    : half_a(a),
      half_b(b),
      apart(pose_a.rotation.transpose() * (pose_b.position - pose_a.position)),
      turn(pose_a.rotation.transpose() * pose_b.rotation),
      scale(a.sum() + b.sum() + apart.cwiseAbs().sum()) {}

void BoxContacts::add(const BoxContact& point) {
  int k = 0;
  while (k < count && points[k].feature != point.feature) ++k;
  if (k == count || point.gap < points[k].gap) points[k] = point;
  count = std::max(count, k + 1);
}

double BoxContacts::least() const {
  double out = std::numeric_limits<double>::infinity();
  for (int k = 0; k < count; ++k) out = std::min(out, points[k].gap);
  return out;
}

void find_box_contacts(const BoxPair& pair, double limit, BoxContacts& out) {
  Axis axis;
  if (!separate(pair, limit, axis)) return;
  const double tolerance = kTie * pair.scale;
  const double to_face =
      std::max(axis.normal.cwiseAbs().maxCoeff(),
               pair.segment() ? 0.0 : (pair.turn.transpose() * axis.normal).cwiseAbs().maxCoeff());
  if (axis.edge_a >= 0 && to_face < kFaceNormal) {
    if (add_edge_crossing(pair, axis, tolerance, out)) return;
  } else {
    Clip(pair, axis.normal, tolerance).run(out);
    if (out.least() <= axis.separation + 10.0 * tolerance || (axis.separation <= 0.0 && out.count > 0))
      return;
    out.count = 0;
  }
  find_closest_box_points(pair, limit, axis.normal, axis.separation, out);
}

namespace {

void add_box_contacts(const BoxPair& pair, const Pose& pose, double radius, ContactSink& sink) {
  BoxContacts found;
  find_box_contacts(pair, sink.margin + radius, found);
  for (int k = 0; k < found.count; ++k) {
    const BoxContact& contact = found.points[k];
    sink.add(pose.position + pose.rotation * contact.on_a, pose.rotation * contact.normal,
             contact.gap - radius, contact.feature);
  }
}

}  // namespace

void add_contacts(const BoxShape& a, const Pose& pose_a, const BoxShape& b, const Pose& pose_b,
                  ContactSink& sink) {
  add_box_contacts(BoxPair(a.half, pose_a, b.half, pose_b), pose_a, 0.0, sink);
}

void add_contacts(const BoxShape& box, const Pose& pose_box, const CapsuleShape& capsule,
                  const Pose& pose_capsule, ContactSink& sink) {
  const Vector3d half(0.0, 0.0, capsule.half_length);
  add_box_contacts(BoxPair(box.half, pose_box, half, pose_capsule), pose_box, capsule.radius, sink);
}

}  // namespace feder
