#pragma once

#include "engine/geometry/bounding_volumes.h"
#include "engine/geometry/plane.h"

namespace feder {

// All volumes are closed: touching counts as overlap, also where rounding alone tells it from a gap. Boxes
// have half edges >= 0, some or all may be 0; their axes are rotations to 1e-15. Nothing here checks its
// input.

/// Half the length of the projection on v: exactly the maximum of v . (corner - centre) up to rounding. v of
/// any length; twice the v, twice the radius.
double projection_radius(const Obb& box, const Vector3d& v);

/// Fast: stops at the first axis that separates. `false` is proven against rounding; where the boxes are
/// apart by more than 1e-12 of |centre_b - centre_a| + their half edges, the answer is `false`. The same for
/// (b, a).
bool overlap(const Obb& a, const Obb& b);

/// The best of the 15 axes. gap > 0: the projections on it are this far apart, a lower bound of the distance
/// (at least 1/sqrt 3 of it). gap <= 0: the boxes overlap and -gap is the shortest translation that parts
/// them. [m]
struct BoxSeparation {
  double gap = 0.0;
  Vector3d axis = Vector3d::UnitX();  ///< unit, from a to b (either way where the centres coincide along it)
  int index = 0;  ///< 0-2: axis of a; 3-5: axis of b; 6 + 3 i + j: axis i of a cross axis j of b
};
/// (b, a) gives the same gap to the last bit and the opposite axis. A face is preferred to an edge pair that
/// is better by rounding only.
BoxSeparation separation(const Obb& a, const Obb& b);

/// An empty sphere overlaps nothing, an empty box neither.
bool overlap(const Sphere& a, const Sphere& b);
bool overlap(const Sphere& sphere, const Aabb& box);
bool overlap(const Sphere& sphere, const Obb& box);

/// Signed distance [m] of the box from the half space normal . x <= offset: <= 0 where they overlap (-depth),
/// > 0 where the box lies on the other side. The same for (10 normal, 10 offset). Misuse: normal 0 or not
/// finite.
double gap(const Obb& box, const Plane& half_space);
/// Does the box meet the plane itself?
bool overlap(const Obb& box, const Plane& plane);

}  // namespace feder
