// Paths of the tool: both closed solutions of two links (notes F2), joints that follow without ever changing
// branch, and what the methods make of singular poses.
#include "solvers/follow_path.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "engine/check.h"
#include "models/robot/arms.h"
#include "solvers/two_link.h"
#include "tests/support/random.h"
#include "tests/support/refused.h"

namespace feder {
namespace {

constexpr double kPi = std::numbers::pi;

// ---- F2: closed form

struct Place {
  double x, y;
};
Place hand(double a, double b, const TwoLinkAngles& q) {
  return {a * std::cos(q.A) + b * std::cos(q.A + q.B), a * std::sin(q.A) + b * std::sin(q.A + q.B)};
}

TEST(TwoLinks, BothBranchesReachTheTarget) {
  Random random(1);
  int reached = 0;
  for (int i = 0; i < 1000; ++i) {
    const double a = random.uniform(0.2, 1.0), b = random.uniform(0.2, 1.0);
    // from inside the ring to its very edges
    const double part = std::pow(10.0, random.uniform(-16.0, 0.0)), inner = std::abs(a - b), outer = a + b;
    const double r = random.below(2) ? inner + part * (outer - inner) : outer - part * (outer - inner);
    const double at = random.uniform(-kPi, kPi), x = r * std::cos(at), y = r * std::sin(at);
    const auto both = two_link_angles(a, b, x, y);
    if (!both) {
      EXPECT_LT(part, 1e-14);  // a rounding of x and y outside
      continue;
    }
    ++reached;
    EXPECT_GE((*both)[0].B, 0.0);
    EXPECT_LE((*both)[1].B, 0.0);
    for (const TwoLinkAngles& q : *both) {
      const Place p = hand(a, b, q);
      EXPECT_LT(std::hypot(p.x - x, p.y - y), 1e-12);  // 3e-16
    }
    if (part > 1e-3) EXPECT_GT((*both)[0].B - (*both)[1].B, 1e-3);
  }
  EXPECT_GT(reached, 900);
}

TEST(TwoLinks, HaveTheCosineOfTheNotes) {
  const double a = 0.8, b = 0.5, x = 0.6, y = 0.7;
  const auto both = two_link_angles(a, b, x, y);
  ASSERT_TRUE(both);
  EXPECT_NEAR(std::cos((*both)[0].B), (x * x + y * y - a * a - b * b) / (2.0 * a * b), 1e-15);
}

TEST(TwoLinks, ReachNothingOutsideTheRing) {
  EXPECT_FALSE(two_link_angles(0.8, 0.5, 1.3001, 0.0));
  EXPECT_FALSE(two_link_angles(0.8, 0.5, 0.2999, 0.0));
  EXPECT_TRUE(two_link_angles(0.8, 0.5, 1.3, 0.0));
  EXPECT_TRUE(two_link_angles(0.6, 0.6, 0.0, 0.0));
  EXPECT_THROW((void)two_link_angles(0.0, 0.5, 0.2, 0.0), InputError);
  EXPECT_THROW((void)two_link_angles(0.5, 0.5, std::nan(""), 0.0), InputError);
}

TEST(TwoLinks, StayOnTheirBranchAndCountTurns) {
  const double a = 0.8, b = 0.5;
  for (const int side : {0, 1}) {
    TwoLinkAngles q = (*two_link_angles(a, b, 0.9, 0.0))[side];
    const TwoLinkAngles start = q;
    double most = 0.0;
    for (int i = 1; i <= 2000; ++i) {
      const double s = i / 1000.0,
                   r = 0.9 + 0.35 * std::sin(6.0 * kPi * s);  // two rounds, r from 0.55 to 1.25
      const auto next = two_link_near(a, b, r * std::cos(2.0 * kPi * s), r * std::sin(2.0 * kPi * s), q);
      ASSERT_TRUE(next);
      most = std::max(most, std::hypot(next->A - q.A, next->B - q.B));
      EXPECT_GT(next->B * start.B, 0.0);
      q = *next;
    }
    EXPECT_LT(most, 0.05);  // 0.037
    EXPECT_NEAR(q.A - start.A, 4.0 * kPi, 1e-12);
    EXPECT_NEAR(q.B, start.B, 1e-12);
  }
}

// ---- Paths

Pose place(double x, double y) {
  return {Matrix3d::Identity(), {x, y, 0.0}};
}

// A straight line at distance `off` from the base of two equal links, which fold there.
std::function<Pose(double)> line_past_the_base(double off) {
  return [=](double s) { return place(1.2 - 2.4 * s, off); };
}

VectorXd start_on(const std::function<Pose(double)>& path, int side) {
  const Vector3d p = path(0.0).position;
  const TwoLinkAngles q = (*two_link_angles(1.0, 1.0, p.x(), p.y()))[side];
  return VectorXd{{q.A, q.B}};
}

double fastest(const PathResult& result) {
  double most = 0.0;
  for (const PathPoint& p : result.points) most = std::max(most, p.speed);
  return most;
}
double farthest(const PathResult& result) {
  double most = 0.0;
  for (const PathPoint& p : result.points) most = std::max(most, p.error.place);
  return most;
}

KinematicMap equal_links() {
  Arm arm = planar_2r(1.0, 1.0);
  for (DhRow& row : arm.rows) row.least = -4.0 * kPi, row.greatest = 4.0 * kPi;
  return kinematic_map(arm);
}

TEST(FollowPath, KeepsItsBranchPastASingularPose) {
  const KinematicMap map = equal_links();
  for (const double off : {0.3, 0.03, 0.003})
    for (const int side : {0, 1}) {
      const auto path = line_past_the_base(off);
      const PathResult result = follow_path(map, path, start_on(path, side));
      ASSERT_TRUE(result.status.ok()) << result.status.reason;
      EXPECT_EQ(result.points.back().s, 1.0);
      EXPECT_LT(farthest(result), 1e-10);
      const double sign = side == 0 ? 1.0 : -1.0;
      for (std::size_t i = 0; i < result.points.size(); ++i) {
        const PathPoint& p = result.points[i];
        EXPECT_GT(sign * std::sin(p.q[1]), 0.0);  // det J keeps its sign
        if (i > 0) EXPECT_LE((p.q - result.points[i - 1].q).lpNorm<Eigen::Infinity>(), 0.2);
      }
      // and is the closed solution on that branch
      const Vector3d end = path(1.0).position;
      const TwoLinkAngles closed = (*two_link_angles(1.0, 1.0, end.x(), end.y()))[side];
      EXPECT_NEAR(std::remainder(result.points.back().q[0] - closed.A, 2.0 * kPi), 0.0, 1e-9);
      EXPECT_NEAR(result.points.back().q[1], closed.B, 1e-9);
    }
}

TEST(FollowPath, SpeedGrowsTowardsASingularPoseUnlessDamped) {
  const KinematicMap map = equal_links();
  const auto near = line_past_the_base(0.003), far = line_past_the_base(0.3);
  const PathResult exact = follow_path(map, near, start_on(near, 0)),
                   calm = follow_path(map, far, start_on(far, 0));
  PathOptions damped;
  damped.method = PathMethod::kDamped;
  const PathResult bounded = follow_path(map, near, start_on(near, 0), damped);
  ASSERT_TRUE(exact.status.ok() && calm.status.ok() && bounded.status.ok());
  EXPECT_GT(fastest(exact), 20.0 * fastest(calm));     // 800 and 8.0 rad/s
  EXPECT_LT(fastest(bounded), 0.02 * fastest(exact));  // 7.9 rad/s
  EXPECT_GT(farthest(bounded), 1e-3);                  // the price
  EXPECT_LT(farthest(bounded), 1e-2);                  // 6.4e-3 m
  EXPECT_LT(bounded.points.back().error.place, 1e-9);  // paid back
}

TEST(FollowPath, StopsWithAReasonWhereThePathLeavesTheReach) {
  const KinematicMap map = equal_links();
  const auto path = [](double s) { return place(1.0 + 2.0 * s, 0.1); };
  const PathResult result = follow_path(map, path, start_on(path, 0));
  EXPECT_EQ(result.status.code, StatusCode::kStepTooSmall);
  EXPECT_NE(result.status.reason.find("smallest singular value"), std::string::npos);
  EXPECT_GT(result.points.back().s, 0.45);  // stretched at s = 0.4987
  EXPECT_LT(result.points.back().s, 0.5);
  for (const PathPoint& p : result.points) {
    EXPECT_TRUE(p.q.allFinite());
    EXPECT_LT(p.error.place, 1e-10);
  }
}

TEST(FollowPath, DampedFollowsOnTheEdgeWhereThePathLeavesTheReach) {
  const KinematicMap map = equal_links();
  const auto path = [](double s) { return place(1.0 + 1.6 * std::sin(kPi * s), 0.1); };
  PathOptions damped;
  damped.method = PathMethod::kDamped;
  damped.duration = 5.0;
  const PathResult result = follow_path(map, path, start_on(path, 0), damped);
  ASSERT_TRUE(result.status.ok()) << result.status.reason;
  EXPECT_NEAR(farthest(result), 0.6, 0.02);
  EXPECT_LT(result.points.back().error.place, 1e-6);
}

TEST(FollowPath, NullSpaceLeadsARedundantArmAwayFromSingularPoses) {
  Arm arm = planar_nr(3);
  for (DhRow& row : arm.rows) row.least = -4.0 * kPi, row.greatest = 4.0 * kPi;
  const KinematicMap map = kinematic_map(arm);
  // folded: all links nearly in line
  const VectorXd q{{0.2, kPi - 0.1, 0.1}};
  const Vector3d from = tool_pose(arm, q).position;
  const auto path = [&](double s) { return place(from.x(), from.y() + 0.02 * s); };
  PathOptions plain, free;
  free.method = PathMethod::kNullSpace;
  const PathResult a = follow_path(map, path, q, plain), b = follow_path(map, path, q, free);
  ASSERT_TRUE(a.status.ok()) << a.status.reason;
  ASSERT_TRUE(b.status.ok()) << b.status.reason;
  EXPECT_LT(farthest(a), 1e-10);
  EXPECT_LT(farthest(b), 1e-10);
  EXPECT_GT(b.points.back().smallest, 2.0 * a.points.back().smallest);  // 0.170 and 0.031
}

TEST(FollowPath, KeepsJointLimitsOfARedundantArm) {
  Arm arm = planar_nr(4);
  const VectorXd q{{0.2, 0.5, 0.5, 0.5}};
  const Vector3d from = tool_pose(arm, q).position;
  const auto path = [&](double s) { return place(from.x() - 0.3 * s, from.y()); };
  const PathResult before = follow_path(kinematic_map(arm), path, q);
  ASSERT_TRUE(before.status.ok());
  ASSERT_GT(before.points.back().q[2], 0.6);  // where it would go
  arm.rows[2].greatest = 0.55;
  const PathResult within = follow_path(kinematic_map(arm), path, q);
  ASSERT_TRUE(within.status.ok()) << within.status.reason;
  EXPECT_LT(farthest(within), 1e-10);
  double most = 0.0;
  for (const PathPoint& p : within.points) most = std::max(most, p.q[2]);
  EXPECT_LE(most, 0.55);
  EXPECT_GT(most, 0.5499);
}

TEST(FollowPath, FollowsWithPlaceAndTurnInSpace) {
  const Arm arm = ur5();
  const KinematicMap map = kinematic_map(arm);
  const VectorXd q{{0.3, -1.2, 1.5, -0.8, -1.4, 0.2}};
  const Pose from = tool_pose(arm, q);
  const auto path = [&](double s) {
    return Pose{Eigen::AngleAxisd(0.8 * s, Vector3d(1.0, 2.0, 2.0) / 3.0).toRotationMatrix() * from.rotation,
                from.position + s * Vector3d(0.1, 0.15, -0.1)};
  };
  const PathResult result = follow_path(map, path, q);
  ASSERT_TRUE(result.status.ok()) << result.status.reason;
  for (const PathPoint& p : result.points) {
    EXPECT_LT(p.error.place, 1e-10);
    EXPECT_LT(p.error.angle, 1e-10);
  }
  EXPECT_GT((result.points.back().q - q).norm(), 0.3);
}

TEST(FollowPath, RefusesBadInput) {
  const KinematicMap map = equal_links();
  const auto path = line_past_the_base(0.3);
  const VectorXd q = start_on(path, 0);
  EXPECT_THROW((void)follow_path(map, path, q + VectorXd{{0.1, 0.0}}), InputError);
  EXPECT_THROW((void)follow_path(map, path, VectorXd{{20.0, 0.0}}), InputError);
  EXPECT_THROW((void)follow_path(map, path, q, {.pieces = 0}), InputError);
  EXPECT_THROW((void)follow_path(map, path, q, {.duration = 0.0}), InputError);
  EXPECT_THROW((void)follow_path(map, path, VectorXd::Zero(3)), MisuseError);
  auto with = [&](const PathOptions& o) { return [&, o] { (void)follow_path(map, path, q, o); }; };
  EXPECT_TRUE(test::refused("damping threshold = nan m", with({.damping = {std::nan(""), 1e-2}})));
  EXPECT_TRUE(test::refused("damping at a singular pose = -1 m^2", with({.damping = {0.1, -1.0}})));
  EXPECT_TRUE(test::refused("null_rate = -1 1/s", with({.null_rate = -1.0})));
  EXPECT_TRUE(test::refused("expected at least what rounding leaves", with({.tolerance = 1e-16})));
  const auto nowhere = [](double) { return place(std::nan(""), 0.0); };
  EXPECT_TRUE(
      test::refused("at s = 0.000000: the pose is not finite", [&] { (void)follow_path(map, nowhere, q); }));
}

// Says so at once, instead of halving its pieces and blaming the arm.
TEST(FollowPath, StopsWhereThePathGivesNoPose) {
  const KinematicMap map = equal_links();
  const auto line = line_past_the_base(0.3);
  const VectorXd q = start_on(line, 0);
  const auto ends = [&](double s) { return s < 0.5 ? line(s) : place(std::nan(""), 0.0); };
  const PathResult broken = follow_path(map, ends, q);
  EXPECT_EQ(broken.status.code, StatusCode::kNonFinite);
  EXPECT_NE(broken.status.reason.find("at s = 0.5"), std::string::npos) << broken.status.reason;
  EXPECT_GT(broken.points.back().s, 0.49);
  const auto grows = [&](double s) {
    Pose pose = line(s);
    pose.rotation *= 1.0 + s;
    return pose;
  };
  const PathResult grown = follow_path(map, grows, q);
  EXPECT_EQ(grown.status.code, StatusCode::kInconsistent);
  EXPECT_NE(grown.status.reason.find("the rotation of the pose is none"), std::string::npos);
}

TEST(FollowPath, StopsAtOnceWhereItStartsAtASingularPose) {
  const KinematicMap map = equal_links();
  const auto inwards = [](double s) { return place(2.0 - s, 0.0); };
  const PathResult result = follow_path(map, inwards, VectorXd{{0.0, 0.0}});
  EXPECT_EQ(result.status.code, StatusCode::kStepTooSmall);
  EXPECT_EQ(result.points.size(), 1u);
  EXPECT_NE(result.status.reason.find("cannot go on at s = 0: smallest singular value 0 m"),
            std::string::npos)
      << result.status.reason;
  // but it may rest there
  const auto rests = [](double) { return place(2.0, 0.0); };
  const PathResult still = follow_path(map, rests, VectorXd{{0.0, 0.0}});
  EXPECT_TRUE(still.status.ok()) << still.status.reason;
  EXPECT_EQ(still.points.back().q, VectorXd({{0.0, 0.0}}));
}

TEST(FollowPath, ComesBackToItsJointsOnAClosedPath) {
  const KinematicMap map = equal_links();
  const auto circle = [](double s) {
    return place(1.0 + 0.3 * std::cos(2.0 * kPi * s), 0.3 * std::sin(2.0 * kPi * s));
  };
  for (const int side : {0, 1}) {
    const VectorXd q = start_on(circle, side);
    const PathResult result = follow_path(map, circle, q);
    ASSERT_TRUE(result.status.ok()) << result.status.reason;
    double away = 0.0;
    for (const PathPoint& p : result.points) away = std::max(away, (p.q - q).norm());
    EXPECT_GT(away, 0.5);
    EXPECT_LT((result.points.back().q - q).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace feder
