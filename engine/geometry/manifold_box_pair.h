#pragma once

#include <array>
#include <cstdint>

#include "engine/geometry/manifold_pairs.h"

namespace feder {

/// Box a and, placed in its axes, box b or the segment inside a capsule [m].
struct BoxPair {
  Vector3d half_a, half_b;  ///< half edges; of a segment (0, 0, half length)
  Vector3d apart;           ///< centre of b
  Matrix3d turn;            ///< columns: axes of b
  double scale;             ///< of the coordinates, for rounding [m]

  BoxPair(const Vector3d& a, const Pose& pose_a, const Vector3d& b, const Pose& pose_b);
  bool segment() const { return half_b.x() == 0.0; }
};

/// In the axes of a; the surface of b is `gap` along the normal from on_a.
struct BoxContact {
  Vector3d on_a, normal;
  double gap;
  std::uint32_t feature;
};

/// Points with features of their own; of two with one feature the one with the smaller gap stays.
struct BoxContacts {
  std::array<BoxContact, 24> points;
  int count = 0;

  void add(const BoxContact& point);
  double least() const;  ///< smallest gap; infinite of none
};

// Features of a box for feature_pair, from a point on it (axes of the box): 1 to 8, and 16 to 27.
std::uint32_t vertex_feature(const Vector3d& corner);
std::uint32_t edge_feature(int axis, const Vector3d& point);
std::uint32_t edge_feature(const Vector3d& from, const Vector3d& to);

/// Contacts of the box with the box or segment; none if they are further apart than `limit`.
void find_box_contacts(const BoxPair& pair, double limit, BoxContacts& out);

/// Where the nearest points of the solids are not those that an axis of separation shows: vertices near the
/// other solid and the nearest crossing of edges, each with its own normal. `normal`: used where they touch.
void find_closest_box_points(const BoxPair& pair, double limit, const Vector3d& normal, double separation,
                             BoxContacts& out);

}  // namespace feder
