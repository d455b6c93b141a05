#include <gtest/gtest.h>

#include "tests/engine/geometry/manifold_support.h"

namespace feder::test {
namespace {

TEST(SphereTorus, GapIsTheSignedDistanceOfTheTorusLessTheRadius) {
  Random random(1);
  for (int trial = 0; trial < 2000; ++trial) {
    const TorusShape torus{random.uniform(0.6, 1.0), random.uniform(0.1, 0.5)};
    const SphereShape sphere{random.uniform(0.0, 0.5)};
    const Pose at = random_pose(random, 1.5), to = random_pose(random, 0.5);
    const Vector3d p = to.rotation.transpose() * (at.position - to.position);
    const double distance = std::hypot(std::hypot(p.x(), p.y()) - torus.major, p.z()) - torus.minor;
    EXPECT_NEAR(deepest(contacts(sphere, at, torus, to)).gap, distance - sphere.radius, 2e-10);
  }
}

TEST(SphereTorus, ABallInTheHoleIsHeldAllAround) {
  const Pose torus, ball{Matrix3d::Identity(), {0, 0, 0.75}};
  const auto points = contacts(SphereShape{1.0}, ball, TorusShape{1.0, 0.25}, torus);
  ASSERT_EQ(points.size(), 4u);
  Vector3d sum = Vector3d::Zero();
  for (const ContactPoint& point : points) {
    EXPECT_EQ(point.gap, 0.0);
    sum += point.normal;
  }
  EXPECT_LT(sum.head<2>().norm(), 1e-15);
}

TEST(HalfSpaceTorus, GapIsTheHeightOfTheLowestPoint) {
  Random random(2);
  for (int trial = 0; trial < 2000; ++trial) {
    const TorusShape torus{random.uniform(0.6, 1.0), random.uniform(0.1, 0.5)};
    const Pose plane = random_pose(random, 1.0);
    Pose pose = random_pose(random, 1.0);
    if (trial % 2) pose.rotation = nudged(plane, std::pow(10.0, random.uniform(-12.0, 0.0)), random).rotation;
    const Vector3d up = plane.rotation.col(2);
    const double tilt = up.cross(pose.rotation.col(2)).norm();
    const double lowest = up.dot(pose.position - plane.position) - torus.major * tilt - torus.minor;
    EXPECT_NEAR(deepest(contacts(HalfSpaceShape{}, plane, torus, pose)).gap, lowest, 2e-10);  // kCloser
  }
}

TEST(HalfSpaceTorus, LyingFlatItStandsOnFourPointsTiltedOnOne) {
  const TorusShape torus{1.0, 0.25};
  const Pose plane, flat{Matrix3d::Identity(), {0, 0, 0.25}};
  const auto points = contacts(torus, flat, HalfSpaceShape{}, plane, 1e-3);
  ASSERT_EQ(points.size(), 4u);
  for (const ContactPoint& point : points) EXPECT_EQ(point.gap, 0.0);
  const Pose tilted{Eigen::AngleAxisd(0.3, Vector3d(1, 2, 0).normalized()).toRotationMatrix(),
                    {0, 0, 0.25 + std::sin(0.3)}};
  EXPECT_EQ(contacts(torus, tilted, HalfSpaceShape{}, plane, 1e-3).size(), 1u);
}

}  // namespace
}  // namespace feder::test
