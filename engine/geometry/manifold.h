#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/geometry/shape.h"

namespace feder {

/// One point of contact, or of near contact, between two solids a and b.
struct ContactPoint {
  Vector3d point;             ///< in the world, midway between the two surfaces [m]
  Vector3d normal;            ///< unit, from a to b
  double gap = 0.0;           ///< distance of the surfaces along the normal; < 0: penetration depth [m]
  std::uint32_t feature = 0;  ///< which features touch; unique in a manifold, the same under small motion
};

/// Appends the contact points of a and b whose gap is at most `margin` [m], in the order of their features.
/// Swapping the arguments turns the normals round and changes neither points nor gaps (features may differ).
void find_contacts(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, double margin,
                   std::vector<ContactPoint>& out);

/// Empty if there is a contact routine for this pair of shapes, otherwise why not.
std::string refuse_pair(const Shape& a, const Shape& b);

}  // namespace feder
