// Random pairs, half of them degenerate: touching, aligned, concentric, without radius or length.
#include <gtest/gtest.h>

#include "tests/engine/geometry/manifold_support.h"
#include "tests/support/campaign.h"

namespace feder::test {
namespace {

double grid(Random& random) {
  return 0.25 * random.below(5);
}

// A rotation that maps axes to axes.
Matrix3d axis_turn(Random& random) {
  Matrix3d out = Matrix3d::Zero();
  const int first = random.below(3), step = 1 + random.below(2);
  for (int i = 0; i < 3; ++i) out(i, (first + step * i) % 3) = random.below(2) ? 1.0 : -1.0;
  if (out.determinant() < 0.0) out.col(0) *= -1.0;
  return out;
}

Shape random_shape(Random& random, bool degenerate) {
  const auto size = [&](double low) {
    return degenerate ? std::max(low, grid(random)) : random.uniform(std::max(low, 0.1), 1.0);
  };
  switch (random.below(4)) {
    case 0:
      return SphereShape{size(0.0)};
    case 1:
      return BoxShape{Vector3d(size(0.25), size(0.25), size(0.25))};
    case 2:
      return CapsuleShape{size(0.0), size(0.0)};
    default:
      return HalfSpaceShape{};
  }
}

Pose degenerate_pose(const Pose& other, Random& random) {
  const Vector3d shift(grid(random), grid(random), grid(random));
  switch (random.below(4)) {
    case 0:
      return other;
    case 1:
      return {other.rotation, other.position + other.rotation * shift};
    case 2:
      return {other.rotation * axis_turn(random), other.position + other.rotation * shift};
    default:
      return {
          other.rotation *
              Eigen::AngleAxisd(0.25 * std::numbers::pi, Vector3d::Unit(random.below(3))).toRotationMatrix(),
          other.position + other.rotation * shift};
  }
}

bool bounded(const Shape& shape) {
  return !std::holds_alternative<HalfSpaceShape>(shape);
}

TEST(ManifoldCampaign, EveryPairOfConvexShapesGivesAManifoldThatHolds) {
  const int cases = campaign_cases(1000000);
  double worst = 0.0;
  int found = 0;
  for (int k = 0; k < cases; ++k) {
    SCOPED_TRACE(testing::Message() << "seed " << k);
    Random random(static_cast<std::uint64_t>(k));
    const bool degenerate = k % 2 == 0;
    const Shape a = random_shape(random, degenerate), b = random_shape(random, degenerate);
    if (!refuse_pair(a, b).empty()) continue;
    const Pose at = degenerate && random.below(2) ? Pose{} : random_pose(random, k % 5 ? 1.0 : 1e3);
    Pose to = degenerate ? degenerate_pose(at, random) : random_pose(random, 1.0);
    if (!degenerate) to.position += at.position;
    const double rounding = 1e-13 * (10.0 + at.position.norm());
    const auto points = contacts(a, at, b, to), swapped = contacts(b, to, a, at);
    ASSERT_FALSE(points.empty());
    ++found;
    for (std::size_t i = 0; i < points.size(); ++i) {
      ASSERT_TRUE(points[i].point.allFinite() && std::isfinite(points[i].gap));
      ASSERT_NEAR(points[i].normal.norm(), 1.0, 1e-14);
      if (i > 0) ASSERT_LT(points[i - 1].feature, points[i].feature);
    }
    // the same from the other side
    const bool same = a.index() == b.index() && at.position == to.position;
    ASSERT_EQ(points.size(), swapped.size());
    for (const ContactPoint& point : points)
      ASSERT_TRUE(same || std::any_of(swapped.begin(), swapped.end(), [&](const ContactPoint& other) {
                    return other.point == point.point && other.gap == point.gap &&
                           other.normal == -point.normal;
                  }));
    // the deepest point shows distance or depth, and moving out along its normal parts them
    const ContactPoint point = deepest(points);
    if (bounded(a) && bounded(b)) {
      const double along = separation(a, at, b, to, point.normal);
      worst = std::max(worst, std::abs(along - point.gap) / rounding);
      ASSERT_NEAR(along, point.gap, 1e3 * rounding);  // 0.7 rounding
      for (int i = 0; i < 20; ++i)
        ASSERT_LE(separation(a, at, b, to, (point.normal + random.vector(i < 10 ? 0.1 : 2.0)).normalized()),
                  point.gap + 1e3 * rounding);
    }
    Pose out = to;
    out.position -= point.gap * point.normal;
    const auto touching = contacts(a, at, b, out);
    ASSERT_FALSE(touching.empty());
    ASSERT_NEAR(deepest(touching).gap, 0.0, 1e3 * rounding);
  }
  RecordProperty("pairs", found);
  RecordProperty("worst", std::to_string(worst));
}

TEST(ManifoldCampaign, BoxesAsMeshesAreAsFarApartAsTheBoxes) {
  const int cases = campaign_cases(100000);
  double worst = 0.0;
  int apart = 0;
  for (int k = 0; k < cases; ++k) {
    SCOPED_TRACE(testing::Message() << "seed " << k);
    Random random(static_cast<std::uint64_t>(k));
    const bool degenerate = k % 2 == 0;
    Vector3d half = positive(random);
    if (degenerate)
      for (double& h : half) h = std::max(0.25, grid(random));
    const Shape a = random_shape(random, degenerate), b = BoxShape{half}, mesh = MeshShape{box_surface(half)};
    const Pose at = degenerate && random.below(2) ? Pose{} : random_pose(random, 1.0);
    Pose to = degenerate ? degenerate_pose(at, random) : random_pose(random, 1.5);
    if (!degenerate) to.position += at.position;
    const auto points = contacts(a, at, mesh, to), swapped = contacts(mesh, to, a, at);
    ASSERT_EQ(points.size(), swapped.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      ASSERT_TRUE(points[i].point.allFinite() && std::isfinite(points[i].gap));
      ASSERT_NEAR(points[i].normal.norm(), 1.0, 1e-14);
      ASSERT_EQ(swapped[i].point, points[i].point);
      ASSERT_EQ(swapped[i].normal, -points[i].normal);
      if (i > 0) ASSERT_LT(points[i - 1].feature, points[i].feature);
    }
    const double gap = deepest(contacts(a, at, b, to)).gap;
    const bool exact = gap > 0.0 || std::holds_alternative<SphereShape>(a) || !bounded(a);
    if (!exact) continue;
    ++apart;
    ASSERT_FALSE(points.empty());
    worst = std::max(worst, std::abs(deepest(points).gap - gap));
    ASSERT_NEAR(deepest(points).gap, gap, 1e-10);  // 2e-15
  }
  RecordProperty("apart", apart);
  RecordProperty("worst", std::to_string(1e12 * worst));
}

TEST(ManifoldCampaign, TorusPairsAreFiniteAndSymmetric) {
  const int cases = campaign_cases(200000);
  double worst = 0.0;
  for (int k = 0; k < cases; ++k) {
    SCOPED_TRACE(testing::Message() << "seed " << k);
    Random random(static_cast<std::uint64_t>(k));
    const bool degenerate = k % 2 == 0;
    Shape a = k % 4 < 2 ? Shape(SphereShape{degenerate ? grid(random) : random.uniform(0.0, 1.0)})
                        : Shape(HalfSpaceShape{});
    const TorusShape torus{degenerate ? 0.5 : random.uniform(0.5, 1.0),
                           degenerate ? 0.25 : random.uniform(0.1, 0.45)};
    const Pose at = degenerate && random.below(2) ? Pose{} : random_pose(random, 1.0);
    const Pose to = degenerate ? degenerate_pose(at, random) : random_pose(random, 1.0);
    const auto points = contacts(a, at, torus, to), swapped = contacts(torus, to, a, at);
    ASSERT_FALSE(points.empty());
    ASSERT_EQ(points.size(), swapped.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      ASSERT_TRUE(points[i].point.allFinite() && std::isfinite(points[i].gap));
      ASSERT_NEAR(points[i].normal.norm(), 1.0, 1e-14);
      ASSERT_EQ(swapped[i].point, points[i].point);
      ASSERT_EQ(swapped[i].normal, -points[i].normal);
    }
    // moved out along the normal of its deepest point the torus touches
    Pose out = to;
    const ContactPoint point = deepest(points);
    out.position -= point.gap * point.normal;
    if (std::holds_alternative<SphereShape>(a) && point.gap < 0.0)
      continue;  // not convex: another part comes
    const double gap = deepest(contacts(a, at, torus, out)).gap;
    worst = std::max(worst, std::abs(gap));
    ASSERT_NEAR(gap, 0.0, 1e-9);  // 4e-15
  }
  RecordProperty("worst", std::to_string(1e12 * worst));
}

}  // namespace
}  // namespace feder::test
