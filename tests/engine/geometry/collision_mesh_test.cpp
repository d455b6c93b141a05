#include "engine/geometry/collision_mesh.h"

#include <gtest/gtest.h>

namespace feder {
namespace {

TEST(CollisionMesh, SaysWhatIsInside) {
  TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                    {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
  const CollisionMesh solid("tetrahedron", mesh);
  EXPECT_NEAR(solid.closest_point({0.1, 0.2, 0.3}, 1.0)->signed_distance, -0.1, 1e-15);
  EXPECT_NEAR(solid.closest_point({-3, 0, -4}, 10.0)->signed_distance, 5.0, 1e-15);
}

}  // namespace
}  // namespace feder
