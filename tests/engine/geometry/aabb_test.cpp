// Boxes along the axes (notes A3, A4).
#include "engine/geometry/aabb.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/random.h"

namespace feder {
namespace {

struct Interval {
  double low, high;
};

// Allen's 13 relations of an interval to [0, 10]: before, meets, overlaps, starts, during, finishes, equals,
// and the converses. All but `before` and `after` share a point.
constexpr Interval kReference = {0, 10};
constexpr Interval kRelation[13] = {{-5, -1}, {-5, 0},  {-5, 5},  {0, 5},  {3, 7},   {5, 10}, {0, 10},
                                    {0, 15},  {-5, 15}, {-5, 10}, {5, 15}, {10, 15}, {11, 15}};
bool shares_a_point(int relation) {
  return relation != 0 && relation != 12;
}

TEST(Aabb, OverlapsForExactlyTheRelationsThatShareAPointOnEveryAxis) {
  const Aabb reference{Vector3d::Constant(kReference.low), Vector3d::Constant(kReference.high)};
  int overlapping = 0;
  for (int x = 0; x < 13; ++x)
    for (int y = 0; y < 13; ++y)
      for (int z = 0; z < 13; ++z) {
        const Aabb box{{kRelation[x].low, kRelation[y].low, kRelation[z].low},
                       {kRelation[x].high, kRelation[y].high, kRelation[z].high}};
        const bool expected = shares_a_point(x) && shares_a_point(y) && shares_a_point(z);
        EXPECT_EQ(overlap(reference, box), expected) << x << ' ' << y << ' ' << z;
        EXPECT_EQ(overlap(box, reference), expected) << x << ' ' << y << ' ' << z;
        overlapping += expected;
      }
  EXPECT_EQ(overlapping, 11 * 11 * 11);
}

TEST(Aabb, TheProofLineWithOrInPlaceOfAndIsWrong) {
  // not (A meets B) = not (P1 and P2 and P3): the boxes share x and y, the line "not A or not B" has no z in
  // it
  const Aabb a{{0, 0, 0}, {1, 1, 1}}, above{{0, 0, 2}, {1, 1, 3}};
  const bool shares_any = a.min[0] <= above.max[0] || a.min[1] <= above.max[1] || a.min[2] <= above.max[2];
  EXPECT_TRUE(shares_any);
  EXPECT_FALSE(overlap(a, above));
}

TEST(Aabb, FitsWhatTheAxesSayInEveryDimension) {
  Random random(1);
  for (int d = 1; d <= 7; ++d) {
    Eigen::MatrixXd points(d, 50);
    for (int j = 0; j < 50; ++j) points.col(j) = random.numbers(d);
    const Bounds bounds = fit_bounds(points);
    for (int i = 0; i < d; ++i) {
      double low = points(i, 0), high = points(i, 0);
      for (int j = 0; j < 50; ++j) {
        low = std::min(low, points(i, j));
        high = std::max(high, points(i, j));
      }
      EXPECT_EQ(bounds.min[i], low);
      EXPECT_EQ(bounds.max[i], high);
    }
    Bounds beside = bounds;
    beside.min[d - 1] = std::nextafter(bounds.max[d - 1], 9.0);
    beside.max[d - 1] = 9.0;
    EXPECT_TRUE(overlap(bounds, bounds));
    EXPECT_FALSE(overlap(bounds, beside));
    EXPECT_FALSE(overlap(beside, bounds));
  }
}

TEST(Aabb, OfAllPointsIsTheMergerOfItsParts) {
  Random random(2);
  std::vector<Vector3d> points;
  for (int i = 0; i < 40; ++i) points.push_back(random.vector());
  const std::span<const Vector3d> all(points);
  const Aabb whole = fit_aabb(all), parts = merged(fit_aabb(all.first(13)), fit_aabb(all.subspan(13)));
  EXPECT_EQ(whole.min, parts.min);
  EXPECT_EQ(whole.max, parts.max);
  EXPECT_EQ(merged(empty_aabb(), whole).min, whole.min);
  EXPECT_EQ(merged(fit_aabb(all.first(39)), points[39]).max, whole.max);
}

TEST(Aabb, OfNoPointsIsEmptyAndOverlapsNothing) {
  const Aabb none = fit_aabb({}), all{Vector3d::Constant(-1e300), Vector3d::Constant(1e300)};
  EXPECT_TRUE(is_empty(none));
  EXPECT_FALSE(overlap(none, all));
  EXPECT_FALSE(overlap(all, none));
  EXPECT_FALSE(overlap(none, none));
  EXPECT_EQ(volume(none), 0.0);
  EXPECT_EQ(surface_area(none), 0.0);
}

TEST(Aabb, MeasuresVolumeAndArea) {
  const Aabb box{{-1, 0, 2}, {1, 3, 6}};
  EXPECT_EQ(volume(box), 24.0);
  EXPECT_EQ(surface_area(box), 52.0);
  const Aabb flat{{0, 0, 0}, {2, 3, 0}};
  EXPECT_EQ(volume(flat), 0.0);
  EXPECT_EQ(surface_area(flat), 12.0);
}

TEST(Aabb, RefusesAPointThatIsNotFinite) {
  const std::vector<Vector3d> points = {{0, 0, 0}, {0, std::nan(""), 0}};
  EXPECT_THROW((void)fit_aabb(points), MisuseError);
  EXPECT_THROW((void)fit_bounds(Eigen::MatrixXd(3, 0)), MisuseError);
}

}  // namespace
}  // namespace feder
