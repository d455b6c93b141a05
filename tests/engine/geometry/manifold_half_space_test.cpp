#include <gtest/gtest.h>

#include "tests/engine/geometry/manifold_support.h"

namespace feder::test {
namespace {

TEST(HalfSpace, GapsAreHeightsOfTheLowestPoints) {
  Random random(1);
  for (int trial = 0; trial < 1000; ++trial) {
    const Pose plane = random_pose(random, 1.0), pose = random_pose(random, 2.0);
    const Vector3d up = plane.rotation.col(2);
    for (const Shape& shape :
         {Shape(SphereShape{random.uniform(0.0, 1.0)}), Shape(BoxShape{positive(random)}),
          Shape(CapsuleShape{0.3, random.uniform(0.0, 1.0)})}) {
      const auto points = contacts(shape, pose, HalfSpaceShape{}, plane);
      const double lowest = -support(shape, pose, -up) - up.dot(plane.position);
      EXPECT_NEAR(deepest(points).gap, lowest, 1e-14);  // 2e-15
      for (const ContactPoint& point : points) {
        EXPECT_EQ(point.normal, Vector3d(-up));
        EXPECT_NEAR(up.dot(point.point - plane.position), 0.5 * point.gap, 1e-14);  // midway
      }
    }
  }
}

TEST(HalfSpace, ARestingBoxStandsOnItsFourCorners) {
  Random random(2);
  for (int trial = 0; trial < 200; ++trial) {
    const Pose plane = random_pose(random, 1.0);
    const BoxShape box{positive(random)};
    const Pose pose{plane.rotation, plane.position + box.half.z() * plane.rotation.col(2)};
    const auto points = contacts(box, pose, HalfSpaceShape{}, plane, 1e-3);
    ASSERT_EQ(points.size(), 4u);
    for (int k = 0; k < 4; ++k) {
      EXPECT_NEAR(points[k].gap, 0.0, 1e-14);  // 4e-16
      const Vector3d p = pose.rotation.transpose() * (points[k].point - pose.position);
      EXPECT_LT((p - box.half.cwiseProduct(Vector3d(k & 1 ? 1 : -1, k & 2 ? 1 : -1, -1))).norm(), 1e-14);
    }
  }
}

TEST(HalfSpace, ALyingCapsuleTouchesAtBothEndsAStandingOneAtOne) {
  const Pose plane, standing{Matrix3d::Identity(), {0, 0, 0.75}},
      lying{Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3d::UnitY()).toRotationMatrix(), {0, 0, 0.25}};
  EXPECT_EQ(contacts(CapsuleShape{0.25, 0.5}, standing, HalfSpaceShape{}, plane, 1e-3).size(), 1u);
  EXPECT_EQ(contacts(CapsuleShape{0.25, 0.5}, lying, HalfSpaceShape{}, plane, 1e-3).size(), 2u);
  EXPECT_EQ(contacts(CapsuleShape{0.25, 0.0}, lying, HalfSpaceShape{}, plane, 1e-3).size(), 1u);
}

}  // namespace
}  // namespace feder::test
