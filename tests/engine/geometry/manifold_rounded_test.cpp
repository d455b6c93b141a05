// Spheres, capsules and boxes against closed forms.
#include <gtest/gtest.h>

#include "tests/engine/geometry/manifold_support.h"

namespace feder::test {
namespace {

TEST(SphereSphere, GapIsTheDistanceOfTheCentresLessTheRadii) {
  Random random(1);
  for (int trial = 0; trial < 1000; ++trial) {
    const SphereShape a{random.uniform(0.0, 1.0)}, b{random.uniform(0.0, 1.0)};
    const Pose at = random_pose(random, 1.0), to = random_pose(random, 1.0);
    const auto points = contacts(a, at, b, to);
    ASSERT_EQ(points.size(), 1u);
    const Vector3d apart = to.position - at.position;
    EXPECT_NEAR(points[0].gap, apart.norm() - a.radius - b.radius, 1e-15);
    EXPECT_LT((points[0].normal - apart.normalized()).norm(), 1e-15);
    const Vector3d half_gap = 0.5 * points[0].gap * points[0].normal;
    EXPECT_NEAR((points[0].point - half_gap - at.position).norm(), a.radius, 2e-15);
    EXPECT_NEAR((points[0].point + half_gap - to.position).norm(), b.radius, 2e-15);
  }
}

TEST(SphereSphere, ConcentricSpheresPartAlongAFixedAxis) {
  const Pose pose{Matrix3d::Identity(), {1, 2, 3}};
  for (double distance : {0.0, 5e-324, 1e-310, 1e-200}) {
    Pose other = pose;
    other.position = {1, 2, 3};
    const Pose origin, apart{Matrix3d::Identity(), {distance, 0, 0}};
    for (const auto& points : {contacts(SphereShape{1.0}, pose, SphereShape{2.0}, other),
                               contacts(SphereShape{1.0}, origin, SphereShape{2.0}, apart)}) {
      ASSERT_EQ(points.size(), 1u);
      EXPECT_EQ(points[0].gap, -3.0);
      EXPECT_NEAR(points[0].normal.norm(), 1.0, 1e-15);
    }
  }
}

TEST(SphereCapsule, GapIsTheDistanceFromTheAxisLessTheRadii) {
  Random random(2);
  for (int trial = 0; trial < 1000; ++trial) {
    const SphereShape a{random.uniform(0.0, 0.5)};
    const CapsuleShape b{random.uniform(0.1, 0.5), random.uniform(0.0, 1.0)};
    const Pose at = random_pose(random, 2.0), to = random_pose(random, 1.0);
    const Vector3d p = to.rotation.transpose() * (at.position - to.position);
    const double along = std::max(0.0, std::abs(p.z()) - b.half_length);
    const auto points = contacts(a, at, b, to);
    ASSERT_EQ(points.size(), 1u);
    EXPECT_NEAR(points[0].gap, std::hypot(p.x(), p.y(), along) - a.radius - b.radius, 1e-14);  // 2e-15
  }
}

// Distance of the axes by sampling both and refining: nothing of the routine's algebra.
double sampled_distance(const CapsuleShape& a, const Pose& at, const CapsuleShape& b, const Pose& to) {
  double low = -1.0, high = 1.0, best = 0.0;
  const auto distance = [&](double s) {
    const Vector3d x = at.position + s * a.half_length * at.rotation.col(2);
    const Vector3d p = to.rotation.transpose() * (x - to.position);
    return std::hypot(p.x(), p.y(), std::max(0.0, std::abs(p.z()) - b.half_length));
  };
  for (int step = 0; step < 120; ++step) {  // convex in s
    const double third = (high - low) / 3.0;
    (distance(low + third) < distance(high - third) ? high : low) +=
        distance(low + third) < distance(high - third) ? -third : third;
    best = distance(0.5 * (low + high));
  }
  return best;
}

TEST(CapsuleCapsule, GapIsTheDistanceOfTheAxesLessTheRadii) {
  Random random(3);
  for (int trial = 0; trial < 1000; ++trial) {
    const CapsuleShape a{random.uniform(0.1, 0.3), random.uniform(0.2, 1.0)},
        b{random.uniform(0.1, 0.3), random.uniform(0.2, 1.0)};
    const Pose at = random_pose(random, 1.0), to = random_pose(random, 1.0);
    const auto points = contacts(a, at, b, to);
    ASSERT_FALSE(points.empty());
    EXPECT_NEAR(deepest(points).gap, sampled_distance(a, at, b, to) - a.radius - b.radius, 1e-9);
  }
}

TEST(CapsuleCapsule, ParallelOnesTouchAtBothEndsOfTheirOverlap) {
  Random random(4);
  for (int trial = 0; trial < 200; ++trial) {
    const Pose at = random_pose(random, 1.0);
    Pose to = at;
    to.position += at.rotation * Vector3d(0.3, 0.4, 0.7);
    if (trial % 2) to.rotation.rightCols(2) *= -1.0;
    const auto points = contacts(CapsuleShape{0.25, 1.0}, at, CapsuleShape{0.125, 0.5}, to);
    ASSERT_EQ(points.size(), 2u);
    double along[2];
    for (int k = 0; k < 2; ++k) {
      EXPECT_NEAR(points[k].gap, 0.125, 1e-14);
      EXPECT_LT((points[k].normal - at.rotation * Vector3d(0.6, 0.8, 0)).norm(), 1e-14);
      along[k] = (at.rotation.transpose() * (points[k].point - at.position)).z();
    }
    EXPECT_NEAR(std::min(along[0], along[1]), 0.2, 1e-14);
    EXPECT_NEAR(std::max(along[0], along[1]), 1.0, 1e-14);
  }
}

TEST(CapsuleCapsule, CrossedThroughEachOtherPartAcrossBoth) {
  const Pose at, to{Eigen::AngleAxisd(1.0, Vector3d::UnitX()).toRotationMatrix(), Vector3d::Zero()};
  const auto points = contacts(CapsuleShape{0.25, 1.0}, at, CapsuleShape{0.125, 1.0}, to);
  ASSERT_EQ(points.size(), 1u);
  EXPECT_NEAR(points[0].gap, -0.375, 1e-15);
  EXPECT_NEAR(std::abs(points[0].normal.x()), 1.0, 1e-15);
}

TEST(SphereBox, GapIsTheDistanceFromTheBoxLessTheRadius) {
  Random random(5);
  for (int trial = 0; trial < 2000; ++trial) {
    const SphereShape a{random.uniform(0.0, 0.5)};
    const BoxShape b{positive(random)};
    const Pose at = random_pose(random, 2.0), to = random_pose(random, 0.5);
    const Vector3d p = to.rotation.transpose() * (at.position - to.position);
    const double depth = (p.cwiseAbs() - b.half).maxCoeff();
    const double distance = depth > 0.0 ? outside(b, to, at.position) : depth;
    const auto points = contacts(a, at, b, to);
    ASSERT_EQ(points.size(), 1u);
    EXPECT_NEAR(points[0].gap, distance - a.radius, 1e-14);
  }
}

TEST(CapsuleBox, LyingOnAFaceTouchesAtTwoPoints) {
  Random random(6);
  for (int trial = 0; trial < 200; ++trial) {
    const BoxShape box{positive(random)};
    const Pose at = random_pose(random, 1.0);
    // along x, its far end over the edge
    const double half = random.uniform(0.1, 1.0) * box.half.x(), shift = box.half.x() - 0.5 * half;
    const Matrix3d along_x = Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3d::UnitY()).toRotationMatrix();
    const Pose to{at.rotation * along_x,
                  at.position + at.rotation * Vector3d(shift, 0.1 * box.half.y(), box.half.z() + 0.25)};
    const auto points = contacts(box, at, CapsuleShape{0.25, half}, to, 1e-3);
    ASSERT_EQ(points.size(), 2u);
    double reach[2];
    for (int k = 0; k < 2; ++k) {
      EXPECT_NEAR(points[k].gap, 0.0, 1e-14);
      EXPECT_LT((points[k].normal - at.rotation.col(2)).norm(), 1e-14);
      reach[k] = (at.rotation.transpose() * (points[k].point - at.position)).x();
    }
    EXPECT_NEAR(std::min(reach[0], reach[1]), shift - half, 1e-14);
    EXPECT_NEAR(std::max(reach[0], reach[1]), box.half.x(), 1e-14);
  }
}

}  // namespace
}  // namespace feder::test
