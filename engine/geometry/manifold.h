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
/// Swapping the arguments turns the normals round and changes neither points nor gaps (features may differ);
/// of two solids alike in everything, place included, no normal can be the opposite of itself.
///
/// The smallest gap of a pair is the distance of the solids. Where they overlap, convex ones without meshes
/// part by -gap along the normal of the deepest point and by no less along any other; where that is not
/// unique (concentric spheres, axes that meet) an axis of the shapes is chosen. Meshes find overlaps from
/// their surfaces, one vertex or pair of edges at a time: right for what is shallow against their features.
///
/// Capsules side by side touch at both ends of their overlap, boxes at all vertices of the polygon their
/// faces share, a torus lying flat, or with a ball centred in its hole, at four points fixed to it.
///
/// Misuse: a pair that refuse_pair refuses, poses or margin that are not finite (the margin may be infinite),
/// sizes outside what engine/geometry/shape.h says.
void find_contacts(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, double margin,
                   std::vector<ContactPoint>& out);

/// Empty if there is a contact routine for this pair of shapes, otherwise why not.
std::string refuse_pair(const Shape& a, const Shape& b);

}  // namespace feder
