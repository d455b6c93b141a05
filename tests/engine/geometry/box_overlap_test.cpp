// Box overlap (notes A10, A11) against exact integers.
#include "engine/geometry/box_overlap.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "engine/check.h"
#include "tests/engine/geometry/box_pairs.h"
#include "tests/support/campaign.h"
#include "tests/support/exact_hulls.h"

namespace feder {
namespace {

using std::numbers::pi;
using test::BoxPair;
using test::random_rotation;

constexpr double kBand = 1e-12;

Obb random_box(Random& random) {
  return {random.vector(), random_rotation(random), test::random_half(random, false)};
}

std::vector<Vector3d> corners(const Obb& box) {
  std::vector<Vector3d> out;
  for (int i = 0; i < 8; ++i)
    out.push_back(box.centre +
                  box.axes * box.half.cwiseProduct(Vector3d(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  return out;
}

double band(const BoxPair& pair) {
  return kBand * ((pair.b.centre - pair.a.centre).norm() + pair.a.half.sum() + pair.b.half.sum());
}

/// The exact answer, and whether moving b by the band along `axis`, or growing it by the band, turns it
/// round.
class Judge {
 public:
  explicit Judge(const BoxPair& pair) {
    include(scale_, pair.a);
    include(scale_, pair.b);
    a_ = exact_corners(scale_, pair.a);
    b_ = exact_corners(scale_, pair.b);
    overlap_ = test::hulls_meet(a_, b_);
  }
  bool overlap() const { return overlap_; }
  bool within(double band, const Vector3d& axis) const {
    if (!overlap_) return test::hulls_meet(a_, test::grown(b_, scale_.whole(band, 2)));
    return !test::hulls_meet(a_, test::shifted(b_, scale_.whole(band * axis, 2)));
  }

 private:
  test::BinaryScale scale_;
  test::ExactPoints a_, b_;
  bool overlap_ = false;
};

TEST(ObbCampaign, EveryAnswerOutsideTheBandIsThatOfExactArithmetic) {
  constexpr std::uint64_t kSeed = 20130501;
  Random random(kSeed);
  const int cases = test::campaign_cases(1000000);
  int overlapping = 0, in_band = 0, wrong = 0;
  std::array<int, 15> decisive{};
  for (int k = 0; k < cases; ++k) {
    const BoxPair pair = test::random_box_pair(random);
    const Judge judge(pair);
    const bool fast = overlap(pair.a, pair.b), swapped = overlap(pair.b, pair.a);
    const BoxSeparation full = separation(pair.a, pair.b), turned = separation(pair.b, pair.a);
    overlapping += judge.overlap();
    if (!judge.overlap()) ++decisive[full.index];

    // symmetric to the last bit, finite, unit
    const bool symmetric = fast == swapped && full.gap == turned.gap &&
                           (full.axis == -turned.axis ||
                            (full.axis == turned.axis && full.axis.dot(pair.b.centre - pair.a.centre) == 0));
    const bool sound = std::isfinite(full.gap) && std::abs(full.axis.norm() - 1.0) < 1e-14;
    if (!symmetric || !sound)
      ADD_FAILURE() << "seed " << kSeed << ", case " << k << (symmetric ? ": not finite" : ": not symmetric");

    const bool full_overlap = full.gap <= 0.0;
    if (fast == judge.overlap() && full_overlap == judge.overlap()) continue;
    if (judge.within(band(pair), full.axis)) {
      ++in_band;
    } else {
      ++wrong;
      ADD_FAILURE() << "seed " << kSeed << ", case " << k << ": exactly " << judge.overlap() << ", fast "
                    << fast << ", gap " << full.gap << " on axis " << full.index;
    }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(overlapping, cases / 4);
  EXPECT_LT(overlapping, cases - cases / 4);
  for (int index = 0; index < 15; ++index) EXPECT_GT(decisive[index], 0) << "axis " << index;
  std::printf("%d pairs, %d overlap, %d inside the band, %d wrong; decisive:", cases, overlapping, in_band,
              wrong);
  for (int count : decisive) std::printf(" %d", count);
  std::printf("\n");
}

TEST(ProjectionRadius, IsTheLargestOverTheEightCorners) {
  Random random(1);
  double worst = 0.0, worst_scaled = 0.0;
  for (int trial = 0; trial < 2000; ++trial) {
    // whole numbers: no rounding, equality is exact
    Obb box;
    box.centre.setZero();
    box.axes = Matrix3d::Identity();
    for (int k = 0; k < 3; ++k) box.half[k] = random.below(100);
    box.axes.col(0).swap(box.axes.col(random.below(3)));
    const Vector3d whole(random.below(99) - 49, random.below(99) - 49, random.below(99) - 49);
    double exact = 0.0;
    for (const Vector3d& corner : corners(box)) exact = std::max(exact, whole.dot(corner));
    EXPECT_EQ(projection_radius(box, whole), exact);

    const Obb turned = random_box(random);
    const Vector3d v = random.vector();
    double largest = 0.0;
    for (const Vector3d& corner : corners(turned)) largest = std::max(largest, v.dot(corner - turned.centre));
    worst = std::max(worst, std::abs(projection_radius(turned, v) - largest));
    worst_scaled = std::max(worst_scaled, std::abs(projection_radius(turned, 10.0 * v) - 10.0 * largest));
  }
  EXPECT_LT(worst, 2e-15);         // 4e-16
  EXPECT_LT(worst_scaled, 2e-14);  // 7e-15
}

TEST(Obb, TheFifteenthAxisAloneCanSeparate) {
  // two bars crossing at an angle, edge towards edge: every other axis sees them overlap
  const Matrix3d A = Eigen::AngleAxisd(0.25 * pi, Vector3d::UnitZ()).toRotationMatrix();
  Matrix3d B;
  B << Eigen::AngleAxisd(0.25 * pi, Vector3d::UnitY()).toRotationMatrix() * Matrix3d::Identity();
  Matrix3d permuted;
  permuted << B.col(2), B.col(0), B.col(1);  // its long axis, y, last
  const Vector3d half(1, 1, 5);
  const double reach = 2.0 * std::numbers::sqrt2;  // of the two edges on x
  for (double beyond : {-0.01, 0.01}) {
    const Obb a{Vector3d::Zero(), A, half}, b{Vector3d(reach + beyond, 0, 0), permuted, half};
    for (int index = 0; index < 14; ++index) {
      Vector3d v = index < 3   ? Vector3d(a.axes.col(index))
                   : index < 6 ? Vector3d(b.axes.col(index - 3))
                               : Vector3d(a.axes.col((index - 6) / 3).cross(b.axes.col((index - 6) % 3)));
      if (v.norm() < 1e-9) continue;
      v.normalize();
      EXPECT_LT(std::abs(v.dot(b.centre)), projection_radius(a, v) + projection_radius(b, v)) << index;
    }
    const BoxSeparation found = separation(a, b);
    EXPECT_EQ(found.index, 14);
    EXPECT_NEAR(found.gap, beyond, 1e-15);  // 7e-16
    EXPECT_LT((found.axis - Vector3d::UnitX()).norm(), 1e-15);
    EXPECT_EQ(overlap(a, b), beyond < 0.0);
  }
}

TEST(Obb, NearlyParallelEdgesNeitherSeparateNorHide) {
  // edge over edge at an angle s, apart by less than s: only their cross product, of length s, can tell
  Random random(2);
  int separated_by_edges = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    SCOPED_TRACE(trial);
    const double s = test::random_size(random, -12.0, -2.0), apart = 0.2 * s * random.uniform();
    const Matrix3d R = random_rotation(random);
    const Matrix3d A = Eigen::AngleAxisd(0.25 * pi, Vector3d::UnitZ()).toRotationMatrix();
    const Matrix3d B = Eigen::AngleAxisd(s, Vector3d::UnitX()).toRotationMatrix() * A;
    const Obb a{Vector3d::Zero(), R * A, {1, 1, 1}};
    const Obb b{(2.0 * std::numbers::sqrt2 + apart) * R.col(0), R * B, {1, 1, 1}};
    const BoxSeparation full = separation(a, b);
    const Judge judge({a, b});
    if (overlap(a, b) != judge.overlap()) {
      EXPECT_TRUE(judge.within(band({a, b}), full.axis)) << s << ' ' << apart;
    }
    separated_by_edges += s < 1e-6 && full.index >= 6 && full.gap > band({a, b});
  }
  // what skipping every axis of norm^2 < 1e-12 would get wrong
  EXPECT_GT(separated_by_edges, 100);  // 192
}

TEST(Obb, SkippingNoAxisWouldSeparateParallelBoxes) {
  // notes A11: nearly parallel edges give v ~ 0. Without rounding taken care of, v of pure rounding
  // "separates".
  Random random(3);
  int plain_wrong = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const Matrix3d R = random_rotation(random);
    const Matrix3d S =
        R * Eigen::AngleAxisd(1e-15 * random.uniform(), random.vector().normalized()).toRotationMatrix();
    const Obb a{Vector3d::Zero(), R, {1, 1, 1}};
    const Obb b{R * Vector3d(2, 2.0 * random.uniform(), 2.0 * random.uniform()), S, {1, 1, 1}};
    const Obb inside{0.999 * b.centre, S, {1, 1, 1}};
    EXPECT_TRUE(overlap(a, b)) << trial;
    EXPECT_TRUE(overlap(a, inside)) << trial;
    EXPECT_LT(separation(a, inside).gap, 0.0) << trial;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const Vector3d v = a.axes.col(i).cross(b.axes.col(j));
        plain_wrong += std::abs(v.dot(b.centre)) > projection_radius(a, v) + projection_radius(b, v);
      }
  }
  EXPECT_GT(plain_wrong, 100);  // 486
}

TEST(Obb, DepthIsTheShortestTranslationThatParts) {
  Random random(4);
  int overlapping = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const Obb a = random_box(random);
    Obb b = random_box(random);
    b.centre *= 0.7;
    const BoxSeparation found = separation(a, b);
    if (found.gap > 0.0) continue;
    ++overlapping;
    Obb moved = b;
    moved.centre += (-found.gap * (1.0 + 1e-9) + 1e-12) * found.axis;
    EXPECT_FALSE(overlap(a, moved));
    for (int other = 0; other < 20; ++other) {
      moved.centre = b.centre - found.gap * (1.0 - 1e-9) * random.vector().normalized();
      EXPECT_TRUE(overlap(a, moved));
    }
  }
  EXPECT_GT(overlapping, 500);
}

TEST(Obb, TouchingBoxesOverlapAndTouchingFacesArePreferred) {
  const Obb a{Vector3d::Zero(), Matrix3d::Identity(), {1, 1, 1}};
  for (const Vector3d& t : {Vector3d(2, 0, 0), Vector3d(2, 2, 0), Vector3d(2, 2, 2), Vector3d(0, -2, 1)}) {
    const Obb b{t, Matrix3d::Identity(), {1, 1, 1}};
    EXPECT_TRUE(overlap(a, b));
    EXPECT_EQ(separation(a, b).gap, 0.0);
    EXPECT_LT(separation(a, b).index, 6);
    const Obb beyond{t * (1.0 + 1e-12), Matrix3d::Identity(), {1, 1, 1}};
    EXPECT_FALSE(overlap(a, beyond));
  }
}

TEST(Sphere, OverlapsSpheresAndBoxesIncludingTouch) {
  const Sphere ball{{3, 0, 0}, 1.0}, empty{};
  EXPECT_TRUE(overlap(ball, Sphere{{0, 0, 0}, 2.0}));
  EXPECT_FALSE(overlap(ball, Sphere{{0, 0, 0}, 1.999}));
  EXPECT_FALSE(overlap(ball, empty));
  EXPECT_TRUE(overlap(ball, Aabb{{0, 0, 0}, {2, 1, 1}}));
  EXPECT_FALSE(overlap(ball, Aabb{{0, 0, 0}, {1.999, 1, 1}}));
  EXPECT_FALSE(overlap(ball, Aabb{{5, 0, 0}, {1, 1, 1}}));
  EXPECT_FALSE(overlap(empty, Aabb{{-9, -9, -9}, {9, 9, 9}}));
  // towards a corner the sphere is nearer than its own box
  EXPECT_FALSE(overlap(Sphere{{2, 2, 2}, 1.7}, Aabb{{0, 0, 0}, {1, 1, 1}}));
  EXPECT_TRUE(overlap(Sphere{{2, 2, 2}, 1.74}, Aabb{{0, 0, 0}, {1, 1, 1}}));
}

TEST(Sphere, OverlapsATurnedBoxWhereItsNearestPointSaysSo) {
  Random random(5);
  int overlapping = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const Obb box = random_box(random);
    const Sphere ball{random.vector(2.0), 0.0};
    // nearest of a fine lattice of the box: above the distance by at most half a diagonal of a cell
    double nearest = 1e9;
    constexpr int kCells = 20;
    for (int i = 0; i <= kCells; ++i)
      for (int j = 0; j <= kCells; ++j)
        for (int k = 0; k <= kCells; ++k) {
          const Vector3d local = box.half.cwiseProduct(2.0 / kCells * Vector3d(i, j, k) - Vector3d::Ones());
          nearest = std::min(nearest, (box.centre + box.axes * local - ball.centre).norm());
        }
    const double cell = box.half.norm() / kCells;
    const bool within = nearest <= 0.6;
    if (within || nearest > 0.6 + cell) {
      EXPECT_EQ(overlap(Sphere{ball.centre, 0.6}, box), within);
      overlapping += within;
    }
  }
  EXPECT_GT(overlapping, 30);  // 37
}

TEST(HalfSpace, GapIsTheLowestCornersHeightWhateverTheNormalsLength) {
  Random random(6);
  double worst = 0.0, worst_scaled = 0.0;
  for (int trial = 0; trial < 2000; ++trial) {
    const Obb box = random_box(random);
    const Plane plane{random.vector(), random.uniform()};
    const Plane longer{10.0 * plane.normal, 10.0 * plane.offset};
    double lowest = 1e9, highest = -1e9;
    for (const Vector3d& corner : corners(box)) {
      const double height = (plane.normal.dot(corner) - plane.offset) / plane.normal.norm();
      lowest = std::min(lowest, height);
      highest = std::max(highest, height);
    }
    const double scale = 1.0 + std::abs(plane.offset) / plane.normal.norm();
    worst = std::max(worst, std::abs(gap(box, plane) - lowest) / scale);
    worst_scaled = std::max(worst_scaled, std::abs(gap(box, longer) - lowest) / scale);
    EXPECT_EQ(overlap(box, plane), lowest <= 0.0 && highest >= 0.0);
    EXPECT_EQ(overlap(box, longer), lowest <= 0.0 && highest >= 0.0);
  }
  EXPECT_LT(worst, 1e-14);         // 7e-16
  EXPECT_LT(worst_scaled, 1e-14);  // 7e-16
}

TEST(HalfSpace, TouchingCountsAndANormalOfZeroIsMisuse) {
  const Obb box{Vector3d(0, 0, 3), Matrix3d::Identity(), {1, 1, 1}};
  EXPECT_EQ(gap(box, {Vector3d::UnitZ(), 2.0}), 0.0);
  EXPECT_TRUE(overlap(box, Plane{Vector3d::UnitZ(), 2.0}));
  EXPECT_FALSE(overlap(box, Plane{Vector3d::UnitZ(), 1.999}));
  EXPECT_EQ(gap(box, {Vector3d::UnitZ(), 3.5}), -1.5);
  EXPECT_THROW((void)gap(box, Plane{Vector3d::Zero(), 1.0}), MisuseError);
}

}  // namespace
}  // namespace feder
