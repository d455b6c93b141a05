// Oriented boxes (notes A7).
#include "engine/geometry/obb.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <vector>

#include "engine/check.h"
#include "engine/geometry/aabb.h"
#include "engine/geometry/best_line.h"
#include "tests/support/random.h"

namespace feder {
namespace {

using std::numbers::pi;

Matrix3d random_rotation(Random& random) {
  return Eigen::AngleAxisd(random.uniform(-pi, pi), random.vector().normalized()).toRotationMatrix();
}

std::vector<Vector3d> box_points(Random& random, int count, const Vector3d& half) {
  std::vector<Vector3d> points;
  for (int i = 0; i < count; ++i) points.push_back(random.vector().cwiseProduct(half));
  return points;
}

std::vector<Vector3d> moved(std::vector<Vector3d> points, const Matrix3d& R, const Vector3d& shift) {
  for (Vector3d& p : points) p = R * p + shift;
  return points;
}

bool contains_all(const Obb& box, const std::vector<Vector3d>& points) {
  for (const Vector3d& p : points)
    if (!contains(box, p)) return false;
  return true;
}

TEST(Obb, ContainsEveryPointWithoutTolerance) {
  Random random(1);
  for (int trial = 0; trial < 2000; ++trial) {
    SCOPED_TRACE(trial);
    const double size = std::pow(10.0, random.uniform(-6.0, 6.0));
    std::vector<Vector3d> points = box_points(random, 1 + random.below(30), size * Vector3d(3, 1, 0.1));
    points = moved(points, random_rotation(random), random.vector(std::pow(10.0, random.uniform(-6.0, 6.0))));
    EXPECT_TRUE(contains_all(fit_obb(points), points));
    EXPECT_TRUE(contains_all(box_along(random_rotation(random), points), points));
  }
}

TEST(Obb, TurnsWithItsPoints) {
  Random random(2);
  for (int trial = 0; trial < 200; ++trial) {
    const std::vector<Vector3d> points = box_points(random, 100, {3, 1, 0.3});
    const Matrix3d R = random_rotation(random);
    const Vector3d shift = random.vector(10.0);
    const Obb before = fit_obb(points), after = fit_obb(moved(points, R, shift));
    EXPECT_LT((after.half - before.half).norm(), 1e-12);                    // 9e-15
    EXPECT_LT((after.centre - (R * before.centre + shift)).norm(), 1e-12);  // 4e-15
    for (int k = 0; k < 3; ++k)
      EXPECT_LT(after.axes.col(k).cross(R * before.axes.col(k)).norm(), 1e-12);  // 3e-15
  }
}

TEST(Obb, OfALongTurnedBoxIsNotLargerThanTheAabb) {
  Random random(3);
  double largest = 0.0, sum = 0.0;
  const Aabb bar{{-10, -1, -0.5}, {10, 1, 0.5}};
  std::vector<Vector3d> corners;
  for (int i = 0; i < 8; ++i)
    corners.emplace_back(i & 1 ? bar.max[0] : bar.min[0], i & 2 ? 1.0 : -1.0, i & 4 ? 0.5 : -0.5);
  for (int trial = 0; trial < 200; ++trial) {
    const auto points = moved(corners, random_rotation(random), random.vector());
    const double ratio = volume(fit_obb(points)) / volume(fit_aabb(points));
    largest = std::max(largest, ratio);
    sum += ratio;
  }
  EXPECT_LT(largest, 1.0);      // 0.50
  EXPECT_LT(sum / 200.0, 0.1);  // 0.075
}

TEST(Obb, CentredAtTheMeanItWouldMissPointsOrBeLarger) {
  // nine in ten points lie in the first tenth of a bar
  Random random(4);
  std::vector<Vector3d> points;
  for (int i = 0; i < 1000; ++i) {
    Vector3d p = random.vector();
    p[0] = i % 10 ? random.uniform(0.0, 1.0) : random.uniform(0.0, 10.0);
    points.push_back(p);
  }
  const Obb box = fit_obb(points);
  ASSERT_TRUE(contains_all(box, points));

  // the same extents about the mean lose points; reaching all of them from there takes a larger box
  Obb about_mean = box;
  about_mean.centre = point_spread(points).mean;
  EXPECT_FALSE(contains_all(about_mean, points));
  for (const Vector3d& p : points)
    about_mean.half = about_mean.half.cwiseMax((box.axes.transpose() * (p - about_mean.centre)).cwiseAbs());
  EXPECT_GT(volume(about_mean) / volume(box), 1.5);  // 1.93
}

TEST(Obb, OfAMeshDoesNotFollowTheDensityOfItsVertices) {
  // a 6 x 2 x 1 box whose top corner is cut into many slivers: vertices crowd there, area does not
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) mesh.vertices.emplace_back(i & 1 ? 6 : 0, i & 2 ? 2 : 0, i & 4 ? 1 : 0);
  mesh.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  for (int i = 0; i < 400; ++i) {
    const int first = static_cast<int>(mesh.vertices.size());
    const double angle = 0.5 * pi * i / 400, next = 0.5 * pi * (i + 1) / 400;
    mesh.vertices.emplace_back(6 - 0.3 * std::cos(angle), 2 - 0.3 * std::sin(angle), 1);
    mesh.vertices.emplace_back(6 - 0.3 * std::cos(next), 2 - 0.3 * std::sin(next), 1);
    mesh.triangles.push_back({7, first, first + 1});
  }
  const Obb by_area = fit_obb(mesh), by_points = fit_obb(mesh.vertices);
  EXPECT_TRUE(contains_all(by_area, mesh.vertices));
  EXPECT_LT(volume(by_area), 13.0);    // 12.2
  EXPECT_GT(volume(by_points), 20.0);  // 28: the vertices' box is skew
}

TEST(Obb, OfSomeTrianglesContainsThoseAlone) {
  const TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {50, 50, 50}}, {{0, 1, 2}, {1, 2, 3}}};
  const std::vector<int> first = {0};
  const Obb box = fit_obb(mesh, first);
  EXPECT_TRUE(contains(box, mesh.vertices[1]));
  EXPECT_FALSE(contains(box, mesh.vertices[3]));
}

TEST(Obb, OfDegenerateInputIsFlatThinOrAPoint) {
  Random random(5);
  for (int trial = 0; trial < 200; ++trial) {
    const Matrix3d R = random_rotation(random);
    const Vector3d shift = random.vector();
    for (const Vector3d& extent : {Vector3d(3, 1, 0), Vector3d(3, 0, 0), Vector3d(0, 0, 0)}) {
      const auto points = moved(box_points(random, 20, extent), R, shift);
      const Obb box = fit_obb(points);
      EXPECT_TRUE(contains_all(box, points));
      EXPECT_TRUE(box.axes.isUnitary(1e-12));
      for (int k = 0; k < 3; ++k)
        if (extent[k] == 0.0) {
          EXPECT_LT(box.half[k], 3e-14);  // 1.2e-14
        }
    }
    const TriangleMesh segment{{shift, shift + R.col(0), shift + 2.0 * R.col(0)}, {{0, 1, 2}}};
    EXPECT_TRUE(contains_all(fit_obb(segment), segment.vertices));
  }
  const std::vector<Vector3d> one = {{1, 2, 3}};
  EXPECT_EQ(fit_obb(one).centre, one[0]);
  EXPECT_EQ(fit_obb(one).half, Vector3d::Zero());
  EXPECT_THROW((void)fit_obb(std::vector<Vector3d>{}), MisuseError);
}

TEST(Obb, OfAnAabbIsTheSameBox) {
  const Obb box = obb_of({{-1, 0, 2}, {3, 1, 5}});
  EXPECT_EQ(box.centre, Vector3d(1, 0.5, 3.5));
  EXPECT_EQ(box.half, Vector3d(2, 0.5, 1.5));
  EXPECT_EQ(volume(box), 12.0);
}

}  // namespace
}  // namespace feder
