// What holds for every pair: refusals, order of the arguments, rigid motion, feature numbers.
#include "engine/geometry/manifold.h"

#include <gtest/gtest.h>

#include "engine/check.h"
#include "tests/engine/geometry/manifold_support.h"

namespace feder::test {
namespace {

std::vector<Shape> shapes() {
  return {SphereShape{0.4},       BoxShape{Vector3d(0.3, 0.5, 0.4)},
          CapsuleShape{0.2, 0.6}, HalfSpaceShape{},
          TorusShape{0.6, 0.2},   MeshShape{box_surface({0.5, 0.2, 0.4})}};
}

TEST(RefusePair, NamesThePairsWithoutARoutine) {
  EXPECT_EQ(refuse_pair(HalfSpaceShape{}, HalfSpaceShape{}),
            "half space and half space: no contact points, their overlap has no end");
  for (const Shape& shape : shapes()) {
    const bool allowed =
        std::holds_alternative<SphereShape>(shape) || std::holds_alternative<HalfSpaceShape>(shape);
    for (const std::string& text :
         {refuse_pair(shape, TorusShape{1, 0.5}), refuse_pair(TorusShape{1, 0.5}, shape)}) {
      EXPECT_EQ(text.empty(), allowed) << text;
      if (!allowed) EXPECT_NE(text.find("use the mesh of the torus"), std::string::npos);
    }
  }
  EXPECT_EQ(refuse_pair(BoxShape{}, TorusShape{}).find("box and torus: "), 0u);
}

TEST(RefusePair, AgreesWithFindContacts) {
  for (const Shape& a : shapes())
    for (const Shape& b : shapes()) {
      if (refuse_pair(a, b).empty())
        EXPECT_NO_THROW(contacts(a, Pose{}, b, Pose{Matrix3d::Identity(), {0.1, 0.2, 0.3}}));
      else
        EXPECT_THROW(contacts(a, Pose{}, b, Pose{}), MisuseError);
    }
}

TEST(FindContacts, RefusesShapesAndPosesThatAreNone) {
  const Pose pose;
  Pose bad = pose;
  bad.position.y() = std::numeric_limits<double>::quiet_NaN();
  const Shape sphere = SphereShape{1.0};
  EXPECT_THROW(contacts(sphere, bad, sphere, pose), MisuseError);
  EXPECT_THROW(contacts(sphere, pose, sphere, bad), MisuseError);
  EXPECT_THROW(contacts(sphere, pose, sphere, pose, bad.position.y()), MisuseError);
  for (const Shape& none : {Shape(SphereShape{-1.0}), Shape(BoxShape{Vector3d(1, 0, 1)}), Shape(MeshShape{}),
                            Shape(CapsuleShape{1.0, -1.0}), Shape(TorusShape{1.0, 1.0})})
    EXPECT_THROW(contacts(none, pose, sphere, pose), MisuseError);
}

TEST(FindContacts, AppendsToWhatIsThere) {
  std::vector<ContactPoint> out(1);
  out[0].gap = 42.0;
  find_contacts(SphereShape{1.0}, Pose{}, SphereShape{1.0}, Pose{Matrix3d::Identity(), {1, 0, 0}}, 0.0, out);
  ASSERT_EQ(out.size(), 2u);
  EXPECT_EQ(out[0].gap, 42.0);
}

template <class Check>
void for_random_pairs(int trials, std::uint64_t seed, Check&& check) {
  Random random(seed);
  const std::vector<Shape> all = shapes();
  for (const Shape& a : all)
    for (const Shape& b : all)
      for (int trial = 0; trial < trials && refuse_pair(a, b).empty(); ++trial) {
        SCOPED_TRACE(testing::Message() << a.index() << " " << b.index() << " " << trial);
        const Pose at = random_pose(random, 0.1), to = random_pose(random, 1.0);
        check(a, at, b, to, random.uniform(-0.1, 0.3), random);
      }
}

TEST(FindContacts, SwappingTheArgumentsTurnsTheNormalsRound) {
  for_random_pairs(
      100, 1, [](const Shape& a, const Pose& at, const Shape& b, const Pose& to, double margin, Random&) {
        auto points = contacts(a, at, b, to, margin), swapped = contacts(b, to, a, at, margin);
        ASSERT_EQ(points.size(), swapped.size());
        for (const ContactPoint& point : points)
          EXPECT_TRUE(std::any_of(swapped.begin(), swapped.end(), [&](const ContactPoint& other) {
            return other.point == point.point && other.gap == point.gap && other.normal == -point.normal;
          }));
      });
}

TEST(FindContacts, FollowRigidMotion) {
  double worst = 0.0;
  for_random_pairs(
      100, 2,
      [&](const Shape& a, const Pose& at, const Shape& b, const Pose& to, double margin, Random& random) {
        const Matrix3d turn = random_turn(random);
        const Vector3d shift = random.vector();
        const auto points = contacts(a, at, b, to, margin);
        const auto others = contacts(a, moved(at, turn, shift), b, moved(to, turn, shift), margin);
        ASSERT_EQ(points.size(), others.size());
        for (const ContactPoint& point : points) {
          double least = 1.0;
          for (const ContactPoint& other : others)
            least = std::min(least, std::max({(other.point - turn * point.point - shift).norm(),
                                              (other.normal - turn * point.normal).norm(),
                                              std::abs(other.gap - point.gap)}));
          worst = std::max(worst, least);
        }
      });
  EXPECT_LT(worst, 1e-12);
}

TEST(FindContacts, FeaturesAreUniqueAndInOrder) {
  for_random_pairs(
      100, 3, [](const Shape& a, const Pose& at, const Shape& b, const Pose& to, double margin, Random&) {
        const auto points = contacts(a, at, b, to, margin);
        for (std::size_t k = 1; k < points.size(); ++k) EXPECT_LT(points[k - 1].feature, points[k].feature);
      });
}

TEST(FindContacts, SmallMotionKeepsFeaturesAndMovesPointsLittle) {
  int compared = 0, changed = 0, far = 0;
  for_random_pairs(
      200, 4,
      [&](const Shape& a, const Pose& at, const Shape& b, const Pose& to, double margin, Random& random) {
        const auto before = contacts(a, at, b, to, margin);
        const auto after = contacts(a, at, b, nudged(to, 1e-6, random), margin);
        if (before.empty()) return;
        const Change change = difference(before, after);
        ++compared;
        changed += change.features ? 1 : 0;
        far += !change.features && change.point > 1e-4 ? 1 : 0;
      });
  RecordProperty("compared", compared);
  RecordProperty("changed", changed);
  RecordProperty("far", far);
  EXPECT_GT(compared, 3000);
  EXPECT_LT(changed, compared / 500);  // 0: a pair may be near to a change of features
  EXPECT_LT(far, compared / 500);      // 0: edges may be nearly parallel
}

// Lying flat or along a line is where a manifold has most to lose: the points it had stay.
TEST(FindContacts, SmallMotionOfWhatLiesFlatKeepsItsPoints) {
  Random random(5);
  const Matrix3d lying = Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3d::UnitY()).toRotationMatrix();
  const Shape box = BoxShape{Vector3d(0.6, 0.5, 0.25)}, capsule = CapsuleShape{0.25, 0.4};
  const Shape mesh = MeshShape{box_surface({0.6, 0.5, 0.25})}, torus = TorusShape{0.5, 0.25};
  const Pose on_top{Matrix3d::Identity(), {0.05, 0.1, 0.5}}, along{lying, {0.05, 0.1, 0.5}},
      turned{Eigen::AngleAxisd(0.3, Vector3d::UnitZ()).toRotationMatrix(), {0.05, 0.1, 0.5}};
  const Pose floor{Matrix3d::Identity(), {0, 0, 0.25}};
  struct Case {
    Shape a, b;
    Pose to;
    std::size_t points;
  };
  const Case cases[] = {{box, capsule, along, 2},
                        {mesh, capsule, along, 2},
                        {HalfSpaceShape{}, torus, floor, 4},
                        {capsule, capsule, Pose{Matrix3d::Identity(), {0.3, 0.4, 0.2}}, 2},
                        {box, mesh, on_top, 4},
                        {mesh, mesh, turned, 6},
                        {box, box, turned, 6}};
  for (const Case& c : cases)
    for (int trial = 0; trial < 200; ++trial) {
      SCOPED_TRACE(testing::Message() << c.a.index() << " " << c.b.index() << " " << trial);
      const Pose at = random_pose(random, 1.0), to = moved(c.to, at.rotation, at.position);
      const auto before = contacts(c.a, at, c.b, to, 1e-3);
      const auto after = contacts(c.a, at, c.b, nudged(to, 1e-6, random), 1e-3);
      ASSERT_GE(before.size(), c.points);
      for (const ContactPoint& point : before) {
        const auto same = std::find_if(after.begin(), after.end(), [&](const ContactPoint& other) {
          return other.feature == point.feature;
        });
        ASSERT_NE(same, after.end());
        EXPECT_LT((same->point - point.point).norm(), 2e-5);
        EXPECT_NEAR(same->gap, point.gap, 1e-5);
      }
    }
}

}  // namespace
}  // namespace feder::test
