// Two boxes: certificates of distance and depth, resting manifolds, small motion.
#include <gtest/gtest.h>

#include <set>

#include "tests/engine/geometry/manifold_support.h"

namespace feder::test {
namespace {

Pose turned_about(const Vector3d& axis, double angle, const Vector3d& position) {
  return {Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix(), position};
}

TEST(BoxBox, GapOfSeparatedBoxesIsTheirDistance) {
  Random random(1);
  int separated = 0;
  double worst = 0.0;
  for (int trial = 0; trial < 20000; ++trial) {
    SCOPED_TRACE(trial);
    const BoxShape a{positive(random)}, b{positive(random)};
    const Pose at = random_pose(random, 0.1), to = random_pose(random, 2.5);
    const auto points = contacts(a, at, b, to);
    ASSERT_FALSE(points.empty());
    const ContactPoint nearest = deepest(points);
    // no two points of the solids are nearer than their separation along any direction
    EXPECT_NEAR(separation(a, at, b, to, nearest.normal), nearest.gap, 1e-11);
    worst = std::max(worst, std::abs(separation(a, at, b, to, nearest.normal) - nearest.gap));
    if (nearest.gap <= 0.0) continue;
    ++separated;
    // and these two are as near as that
    const Vector3d half_gap = 0.5 * nearest.gap * nearest.normal;
    EXPECT_LT(outside(a, at, nearest.point - half_gap), 1e-11);
    EXPECT_LT(outside(b, to, nearest.point + half_gap), 1e-11);
  }
  RecordProperty("worst", std::to_string(worst));
  EXPECT_GT(separated, 5000);
}

TEST(BoxBox, DepthIsTheLeastTranslationOfADirectionSweep) {
  Random random(2);
  int overlapping = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    SCOPED_TRACE(trial);
    const BoxShape a{positive(random)}, b{positive(random)};
    const Pose at = random_pose(random, 0.1), to = random_pose(random, 0.8);
    const ContactPoint point = deepest(contacts(a, at, b, to));
    if (point.gap > 0.0) continue;
    ++overlapping;
    EXPECT_NEAR(separation(a, at, b, to, point.normal), point.gap, 1e-12);
    for (int k = 0; k < 300; ++k) {
      const Vector3d other =
          k % 2 ? random.vector().normalized() : (point.normal + random.vector(1e-2)).normalized();
      EXPECT_LE(separation(a, at, b, to, other), point.gap + 1e-12);
    }
  }
  EXPECT_GT(overlapping, 1000);
}

// Area of a convex polygon of points in a plane z = const, in any order.
double area(std::vector<Vector3d> points) {
  Vector3d middle = Vector3d::Zero();
  for (const Vector3d& p : points) middle += p / static_cast<double>(points.size());
  const auto angle = [&](const Vector3d& p) { return std::atan2(p.y() - middle.y(), p.x() - middle.x()); };
  std::sort(points.begin(), points.end(),
            [&](const Vector3d& p, const Vector3d& q) { return angle(p) < angle(q); });
  double twice = 0.0;
  for (std::size_t k = 0; k < points.size(); ++k)
    twice += points[k].cross(points[(k + 1) % points.size()]).z();
  return 0.5 * twice;
}

std::vector<Vector3d> in_axes(const Pose& pose, const std::vector<ContactPoint>& points) {
  std::vector<Vector3d> out;
  for (const ContactPoint& point : points)
    out.push_back(pose.rotation.transpose() * (point.point - pose.position));
  return out;
}

TEST(BoxBox, ASmallBoxOnALargeOneStandsOnFourPoints) {
  Random random(3);
  for (int trial = 0; trial < 500; ++trial) {
    SCOPED_TRACE(trial);
    const BoxShape large{Vector3d(2, 2, 0.5)}, small{positive(random)};
    const Pose at = random_pose(random, 1.0);
    const Pose local =
        turned_about(Vector3d::UnitZ(), random.uniform(-3, 3),
                     {random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4), 0.5 + small.half.z()});
    const Pose to = moved(local, at.rotation, at.position);
    const auto points = contacts(large, at, small, to, 1e-3);
    ASSERT_EQ(points.size(), 4u);
    for (const ContactPoint& point : points) {
      EXPECT_NEAR(point.gap, 0.0, 1e-14);  // 2e-15
      EXPECT_LT((point.normal - at.rotation.col(2)).norm(), 1e-14);
    }
    EXPECT_NEAR(area(in_axes(at, points)), 4.0 * small.half.x() * small.half.y(), 1e-13);
  }
}

TEST(BoxBox, AlignedEqualBoxesStandOnFourPoints) {
  for (double tilt : {0.0, 1e-12, 1e-9, 1e-6}) {
    Random random(4);
    const BoxShape box{Vector3d(0.5, 0.4, 0.3)};
    const Pose below = random_pose(random, 1.0);
    Pose above{below.rotation, below.position + 0.6 * below.rotation.col(2)};
    if (tilt > 0.0) above = nudged(above, tilt, random);
    const auto points = contacts(box, below, box, above, 1e-3);
    ASSERT_EQ(points.size(), 4u) << tilt;
    EXPECT_NEAR(area(in_axes(below, points)), 0.8, 1e-13 + 10.0 * tilt);
    for (const ContactPoint& point : points) EXPECT_NEAR(point.gap, 0.0, 1e-14 + 4.0 * tilt);
  }
}

TEST(BoxBox, SquaresTurnedByAnEighthMeetInAnOctagon) {
  const BoxShape box{Vector3d(1, 1, 0.5)};
  const auto points =
      contacts(box, Pose{}, box, turned_about(Vector3d::UnitZ(), 0.25 * std::numbers::pi, {0, 0, 1}), 1e-3);
  ASSERT_EQ(points.size(), 8u);
  EXPECT_NEAR(area(in_axes(Pose{}, points)), 8.0 * (std::sqrt(2.0) - 1.0), 1e-14);
}

TEST(BoxBox, CrossedEdgesTouchAtOnePoint) {
  const double quarter = 0.25 * std::numbers::pi, reach = std::sqrt(2.0);
  const BoxShape box{Vector3d(1, 1, 1)};
  for (double gap : {-0.1, 0.0, 0.1}) {
    const Pose below = turned_about(Vector3d::UnitX(), quarter, Vector3d::Zero());
    const Pose above = turned_about(Vector3d::UnitY(), quarter, {0.1, 0.2, 2.0 * reach + gap});
    const auto points = contacts(box, below, box, above, 0.2);
    ASSERT_EQ(points.size(), 1u);
    EXPECT_NEAR(points[0].gap, gap, 1e-14);
    EXPECT_LT((points[0].normal - Vector3d::UnitZ()).norm(), 1e-14);
    EXPECT_LT((points[0].point - Vector3d(0.1, 0.0, reach + 0.5 * gap)).norm(), 1e-14);
  }
}

TEST(BoxBox, SmallMotionOfARestingBoxKeepsFeaturesAndMovesPointsLittle) {
  Random random(5);
  int changed = 0;
  double farthest = 0.0, gap = 0.0;
  for (int trial = 0; trial < 3000; ++trial) {
    const BoxShape a{positive(random)}, b{positive(random)};
    const Pose at = random_pose(random, 0.1);
    // aligned every other time, and every fourth of equal size and centred: corner on corner
    const bool aligned = trial % 2 == 0, equal = trial % 4 == 0;
    const double shift = equal ? 0.0 : 0.3, angle = aligned ? 0.0 : random.uniform(0.1, 1.4);
    const BoxShape& upper = equal ? a : b;
    const Pose local = turned_about(
        Vector3d::UnitZ(), angle,
        {random.uniform(-1, 1) * shift, random.uniform(-1, 1) * shift, a.half.z() + upper.half.z()});
    const Pose to = moved(local, at.rotation, at.position);
    const auto before = contacts(a, at, upper, to, 0.01);
    ASSERT_GE(before.size(), 3u);
    const Change change = difference(before, contacts(a, at, upper, nudged(to, 1e-6, random), 0.01));
    changed += change.features ? 1 : 0;
    if (change.features) continue;
    farthest = std::max(farthest, change.point);
    gap = std::max(gap, change.gap);
  }
  RecordProperty("changed", changed);
  RecordProperty("farthest", std::to_string(1e6 * farthest));
  EXPECT_LT(changed, 6);      // 0
  EXPECT_LT(farthest, 1e-4);  // 1.6e-5: crossings of edges at a tenth of a right angle
  EXPECT_LT(gap, 1e-5);
}

}  // namespace
}  // namespace feder::test
