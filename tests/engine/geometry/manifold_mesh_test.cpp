// Meshes: boxes as meshes against boxes, a torus as a mesh against the torus, resting manifolds.
#include <gtest/gtest.h>

#include "tests/engine/geometry/manifold_support.h"

namespace feder::test {
namespace {

TEST(SphereMesh, ABoxAsAMeshHasTheGapOfTheBox) {
  Random random(1);
  for (int trial = 0; trial < 2000; ++trial) {
    SCOPED_TRACE(trial);
    const BoxShape box{positive(random)};
    const MeshShape mesh{box_surface(box.half)};
    const SphereShape sphere{random.uniform(0.0, 0.5)};
    const Pose at = random_pose(random, 1.5), to = random_pose(random, 0.5);
    const auto expected = contacts(sphere, at, box, to), points = contacts(sphere, at, mesh, to);
    ASSERT_FALSE(points.empty());
    EXPECT_NEAR(deepest(points).gap, expected[0].gap, 1e-14);
    EXPECT_LT((deepest(points).normal - expected[0].normal).norm(), 1e-12);
  }
}

TEST(SphereMesh, ASphereInACornerTouchesAllThreeWalls) {
  // three plates as one mesh
  TriangleMesh walls;
  for (int axis = 0; axis < 3; ++axis) {
    const auto plate = box_surface(Vector3d::Ones());
    const int first = static_cast<int>(walls.vertices.size());
    Vector3d half = Vector3d::Constant(2.0), shift = Vector3d::Zero();
    half[axis] = 0.1, shift[axis] = -0.1;
    for (const Vector3d& x : plate->mesh().vertices) walls.vertices.push_back(x.cwiseProduct(half) + shift);
    for (const auto& [a, b, c] : plate->mesh().triangles)
      walls.triangles.push_back({first + a, first + b, first + c});
  }
  const MeshShape mesh{std::make_shared<CollisionMesh>("walls", walls)};
  const Pose ball{Matrix3d::Identity(), {0.5, 0.51, 0.52}};
  const auto points = contacts(SphereShape{0.5}, ball, mesh, Pose{}, 0.05);
  ASSERT_EQ(points.size(), 3u);
  Vector3d gaps = Vector3d::Zero();
  for (const ContactPoint& point : points) gaps -= (point.gap + 1.0) * point.normal;
  EXPECT_LT((gaps - Vector3d(1.0, 1.01, 1.02)).norm(), 1e-14);
}

TEST(SphereMesh, ATorusAsAMeshConvergesToTheTorusWithOrderTwo) {
  Random random(2);
  const TorusShape torus{1.0, 0.4};
  double error[3] = {};
  for (int trial = 0; trial < 100; ++trial) {
    const Pose at = random_pose(random, 1.5), to = random_pose(random, 0.2);
    for (int finer = 0; finer < 3; ++finer) {
      static const std::shared_ptr<const CollisionMesh> surfaces[3] = {
          torus_surface(torus, 48, 24), torus_surface(torus, 96, 48), torus_surface(torus, 192, 96)};
      const MeshShape mesh{surfaces[finer]};
      const double exact = deepest(contacts(SphereShape{0.1}, at, torus, to)).gap;
      error[finer] = std::max(
          error[finer], std::abs(deepest(contacts(SphereShape{0.1}, at, mesh, to, exact + 0.1)).gap - exact));
    }
  }
  EXPECT_LT(error[2], 1e-3);
  for (int finer = 0; finer < 2; ++finer) EXPECT_NEAR(std::log2(error[finer] / error[finer + 1]), 2.0, 0.3);
}

TEST(HalfSpaceMesh, ABoxAsAMeshHasTheCornersOfTheBox) {
  Random random(3);
  for (int trial = 0; trial < 500; ++trial) {
    SCOPED_TRACE(trial);
    const BoxShape box{positive(random)};
    const MeshShape mesh{box_surface(box.half)};
    const Pose plane = random_pose(random, 1.0), pose = random_pose(random, 1.0);
    const double margin = random.uniform(-0.5, 0.5);
    const auto expected = contacts(box, pose, HalfSpaceShape{}, plane, margin);
    const auto points = contacts(mesh, pose, HalfSpaceShape{}, plane, margin);
    ASSERT_EQ(points.size(), expected.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
      EXPECT_NEAR(points[k].gap, expected[k].gap, 1e-14);
      EXPECT_LT((points[k].point - expected[k].point).norm(), 1e-14);
    }
  }
}

TEST(CapsuleMesh, ABoxAsAMeshHasTheGapOfTheBox) {
  Random random(4);
  int compared = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    SCOPED_TRACE(trial);
    const BoxShape box{positive(random)};
    const MeshShape mesh{box_surface(box.half)};
    const CapsuleShape capsule{random.uniform(0.1, 0.3), random.uniform(0.0, 1.0)};
    const Pose at = random_pose(random, 2.0), to = random_pose(random, 0.2);
    const double expected = deepest(contacts(capsule, at, box, to)).gap;
    if (expected < -capsule.radius) continue;  // the axis inside
    ++compared;
    const auto points = contacts(capsule, at, mesh, to);
    ASSERT_FALSE(points.empty());
    EXPECT_NEAR(deepest(points).gap, expected, 1e-11);
  }
  EXPECT_GT(compared, 2000);
}

TEST(BoxMesh, ARestingBoxHasTheManifoldOfTwoBoxes) {
  Random random(5);
  for (int trial = 0; trial < 300; ++trial) {
    SCOPED_TRACE(trial);
    const BoxShape below{Vector3d(1.0, 0.8, 0.5)}, above{positive(random)};
    const Pose at = random_pose(random, 1.0);
    const Matrix3d turn = Eigen::AngleAxisd(random.uniform(0.1, 1.4), Vector3d::UnitZ()).toRotationMatrix();
    const Pose local{turn,
                     {random.uniform(-0.8, 0.8), random.uniform(-0.8, 0.8), 0.5 + above.half.z() - 1e-3}};
    const Pose to = moved(local, at.rotation, at.position);
    const auto expected = contacts(below, at, above, to, 1e-2);
    const MeshShape mesh_below{box_surface(below.half)}, mesh_above{box_surface(above.half)};
    for (const auto& points :
         {contacts(below, at, mesh_above, to, 1e-2), contacts(mesh_below, at, above, to, 1e-2),
          contacts(mesh_below, at, mesh_above, to, 1e-2)}) {
      ASSERT_EQ(points.size(), expected.size());
      for (const ContactPoint& point : points) {
        EXPECT_NEAR(point.gap, -1e-3, 1e-13);
        EXPECT_LT((point.normal - at.rotation.col(2)).norm(), 1e-13);
        EXPECT_TRUE(std::any_of(expected.begin(), expected.end(), [&](const ContactPoint& other) {
          return (other.point - point.point).norm() < 1e-12;
        }));
      }
    }
  }
}

TEST(BoxMesh, AlignedEqualBoxesStandOnTheirCorners) {
  const BoxShape box{Vector3d(0.5, 0.4, 0.3)};
  const MeshShape mesh{box_surface(box.half)};
  Random random(6);
  for (double tilt : {0.0, 1e-9, 1e-6}) {
    SCOPED_TRACE(tilt);
    const Pose below = random_pose(random, 1.0);
    Pose above{below.rotation, below.position + 0.6 * below.rotation.col(2)};
    if (tilt > 0.0) above = nudged(above, tilt, random);
    for (const auto& points :
         {contacts(box, below, mesh, above, 1e-3), contacts(mesh, below, mesh, above, 1e-3)}) {
      int corners[4] = {};
      for (const ContactPoint& point : points) {
        EXPECT_NEAR(point.gap, 0.0, 1e-14 + 4.0 * tilt);
        EXPECT_LT((point.normal - below.rotation.col(2)).norm(), 1e-14 + 4.0 * tilt);
        const Vector3d p = below.rotation.transpose() * (point.point - below.position);
        ++corners[(p.x() > 0.0 ? 1 : 0) + (p.y() > 0.0 ? 2 : 0)];
      }
      for (int corner : corners) EXPECT_GE(corner, 1);
    }
  }
}

TEST(BoxMesh, GapOfSeparatedAndTouchingBoxesIsThatOfTheBoxes) {
  Random random(7);
  int compared = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    SCOPED_TRACE(trial);
    const BoxShape a{positive(random)}, b{positive(random)};
    const MeshShape mesh_a{box_surface(a.half)}, mesh_b{box_surface(b.half)};
    const Pose at = random_pose(random, 0.2), to = random_pose(random, 1.5);
    const ContactPoint expected = deepest(contacts(a, at, b, to));
    // shallow: the nearest features are those that overlap
    if (expected.gap < 0.0) continue;
    Pose shifted = to;
    if (trial % 2) shifted.position -= (expected.gap + 1e-6) * expected.normal;
    const ContactPoint exact = deepest(contacts(a, at, b, shifted));
    if (trial % 2 && exact.normal.dot(expected.normal) < 0.999999) continue;
    ++compared;
    for (const auto& points : {contacts(a, at, mesh_b, shifted), contacts(mesh_a, at, mesh_b, shifted)}) {
      ASSERT_FALSE(points.empty());
      EXPECT_NEAR(deepest(points).gap, exact.gap, trial % 2 ? 1e-12 : 1e-11);
    }
  }
  EXPECT_GT(compared, 1000);
}

}  // namespace
}  // namespace feder::test
