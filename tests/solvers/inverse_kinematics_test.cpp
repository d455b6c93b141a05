// Inverse kinematics (notes F2, F3): solves over the catalogue of arms and what follows from them.
#include "solvers/inverse_kinematics.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "engine/check.h"
#include "models/robot/arms.h"
#include "solvers/null_space.h"
#include "tests/support/campaign.h"
#include "tests/support/random.h"
#include "tests/support/refused.h"

namespace feder {
namespace {

constexpr double kPi = std::numbers::pi;

VectorXd random_joints(Random& random, const KinematicMap& map) {
  VectorXd q(map.joints());
  for (int i = 0; i < q.size(); ++i) q[i] = random.uniform(map.least[i], map.greatest[i]);
  return q;
}

bool within_limits(const KinematicMap& map, const VectorXd& q) {
  return (q.array() >= map.least.array()).all() && (q.array() <= map.greatest.array()).all();
}

// ---- Solves

class EveryArm : public testing::TestWithParam<std::string> {
 protected:
  const Arm arm = make_arm(GetParam());
  const KinematicMap map = kinematic_map(arm);
};
std::vector<std::string> names() {
  std::vector<std::string> list;
  for (const ArmInfo& info : arm_list()) list.push_back(info.name);
  return list;
}
std::string name_of(const testing::TestParamInfo<std::string>& info) {
  return info.param;
}
INSTANTIATE_TEST_SUITE_P(Arms, EveryArm, testing::ValuesIn(names()), name_of);

// Distance of the tool from the target in what the arm's task asks for, by the chain of transforms alone.
double pose_distance(const Arm& arm, const VectorXd& q, const Pose& target) {
  const Pose tool = tool_pose(arm, q);
  const Vector3d way = tool.position - target.position;
  if (arm.task.size() == 2) return way.head<2>().norm();
  if (arm.task.size() == 3) return (tool.rotation - target.rotation).norm() / std::sqrt(2.0);
  return std::max(way.norm(), (tool.rotation - target.rotation).norm() / std::sqrt(2.0));
}

TEST_P(EveryArm, ReachesPosesOfItsOwn) {
  InverseKinematics solver(map);
  Random random(10);
  for (int i = 0; i < 100; ++i) {
    const Pose target = tool_pose(arm, random_joints(random, map));
    const InverseKinematicsResult result = solver.solve(target);
    EXPECT_EQ(result.outcome, PoseOutcome::kReached);
    EXPECT_TRUE(result.status().ok());
    EXPECT_FALSE(result.proved);
    EXPECT_TRUE(within_limits(map, result.q));
    EXPECT_LT(pose_distance(arm, result.q, target), 1e-10);  // 1e-11
  }
}

TEST_P(EveryArm, FindsTheClosestPoseToWhatIsOutOfReach) {
  InverseKinematics solver(map);
  Random random(11);
  for (int i = 0; i < 20; ++i) {
    Pose target = tool_pose(arm, random_joints(random, map));
    const Vector3d out = (target.position - map.reach.centre).normalized();
    target.position = map.reach.centre + random.uniform(1.01, 2.0) * map.reach.greatest * out;
    const InverseKinematicsResult result = solver.solve(target);
    EXPECT_EQ(result.outcome, PoseOutcome::kUnreachable);
    EXPECT_TRUE(result.proved);
    EXPECT_EQ(result.status().code, StatusCode::kInconsistent);
    ASSERT_TRUE(result.q.allFinite());
    EXPECT_TRUE(within_limits(map, result.q));
    // no neighbour within the limits is closer
    JointStep at(map, map.reach.greatest / 3.0);
    at.linearise(result.q, target);
    const double least = at.error().norm();
    ASSERT_GT(least, 1e-3);
    for (int k = 0; k < 50; ++k) {
      const VectorXd near =
          (result.q + random.numbers(map.joints(), 1e-3)).cwiseMax(map.least).cwiseMin(map.greatest);
      at.linearise(near, target);
      EXPECT_GE(at.error().norm(), least * (1.0 - 1e-12));
    }
    if (arm.task.size() == 2)
      EXPECT_NEAR(result.error.place, (target.position - map.reach.centre).norm() - map.reach.greatest,
                  1e-12);
  }
}

TEST(InverseKinematics, StretchesTowardsTheMiddleOfTheRingItCannotEnter) {
  InverseKinematics solver(kinematic_map(planar_2r(0.8, 0.5)));
  const InverseKinematicsResult result =
      solver.solve({Matrix3d::Identity(), {0.1, 0.0, 0.0}}, VectorXd{{0.3, 0.4}});
  EXPECT_EQ(result.outcome, PoseOutcome::kUnreachable);
  EXPECT_TRUE(result.proved);
  EXPECT_NEAR(result.error.place, 0.2, 1e-12);
}

TEST(InverseKinematics, SaysUnreachableWithoutAProofWhereOnlyTheLimitsForbid) {
  Arm arm = planar_2r(0.8, 0.5);
  arm.rows[0].least = 0.0, arm.rows[0].greatest = 1.0;
  arm.rows[1].least = 0.1, arm.rows[1].greatest = 1.0;
  InverseKinematics solver(kinematic_map(arm), {.most_starts = 20});
  const InverseKinematicsResult result = solver.solve({Matrix3d::Identity(), {-1.0, 0.0, 0.0}});
  EXPECT_EQ(result.outcome, PoseOutcome::kUnreachable);
  EXPECT_FALSE(result.proved);
  // both joints as far round as they go
  EXPECT_EQ(result.q, VectorXd({{1.0, 1.0}}));
}

// |A^T e| / (|A| |e|) over the joints that the limits leave free to go downhill.
double left_downhill(const KinematicMap& map, const VectorXd& q, const Pose& target) {
  JointStep at(map, map.reach.greatest / 3.0);
  at.linearise(q, target);
  const VectorXd slope = at.matrix().transpose() * at.error();
  double squared = 0.0;
  for (int i = 0; i < q.size(); ++i)
    if (slope[i] > 0.0 ? q[i] < map.greatest[i] : q[i] > map.least[i]) squared += slope[i] * slope[i];
  return std::sqrt(squared) / (at.matrix().norm() * at.error().norm());
}

// Joints held at limits by a step that the gradient would bring in again are no minimum.
TEST(InverseKinematics, EndsEveryDescentAtAMinimumWithinTheLimits) {
  for (const Arm& arm : {stanford(), puma560()}) {
    const KinematicMap map = kinematic_map(arm);
    InverseKinematics solver(map, {.most_starts = 1});
    Random random(5);
    int closest = 0;
    for (int i = 0; i < 3000; ++i) {
      Pose target = tool_pose(arm, random_joints(random, map));
      target.position = map.reach.centre + 1.05 * (target.position - map.reach.centre);
      const InverseKinematicsResult result = solver.solve(target);
      if (result.outcome != PoseOutcome::kUnreachable) continue;
      ++closest;
      EXPECT_LT(left_downhill(map, result.q, target), 1e-5) << arm.name << ' ' << i;  // 9e-7
    }
    EXPECT_GT(closest, 500) << arm.name;
  }
}

// Nearly stretched, and what reaches the target lies in valleys away from the best local minimum.
TEST(InverseKinematics, FollowsTheNarrowValleysAtTheEdgeOfTheReach) {
  const std::vector<std::vector<double>> known = {
      {1.1519735673638061, -1.5692621555290285, 0.096429325251708331, -0.46546623062005876,
       0.049497304325047953, 1.8413996748591985, -2.4988669806530552},
      {1.4754846148508531, 1.5365124987347825, 2.6489785694018093, -0.44225238050414628, 0.033395185333188859,
       1.9846266081214243, 2.1213881744030165},
      {-2.7298631301069225, -1.4129653850384203, -0.34009274165183179, -0.481260105521788,
       0.18409636867294354, 2.7713797996837966, 1.5108756101945411},
      {0.13685820857028608, -1.7251142717221941, -0.95613910927623458, -0.4326313112932092,
       0.073209847795558503, 1.148922876130837, 1.0734804820145518},
      {-0.30114076843629167, 1.6773228986100648, 2.5092900405825787, -0.47448546433896732,
       0.21044740843382481, 1.0040273468996876, 0.89649583596726012},
      {-2.0757810773961793, -1.4526336563557031, 0.068330617336893607, -0.47243164560055728,
       -0.057448223221177025, 2.6070789824208447, -0.42315360733636931}};
  const Arm arm = panda();
  InverseKinematics solver(kinematic_map(arm));
  for (const std::vector<double>& joints : known) {
    const Pose target = tool_pose(arm, VectorXd::Map(joints.data(), 7));
    const InverseKinematicsResult result = solver.solve(target);
    EXPECT_EQ(result.outcome, PoseOutcome::kReached) << result.status().reason;
    EXPECT_LT(pose_distance(arm, result.q, target), 1e-10);
    EXPECT_EQ(result.starts, 200);  // none of them gets there in its turn
  }
}

// Millimetres and kilometres.
TEST(InverseKinematics, ReachesWithArmsOfAnySize) {
  for (const double size : {1e-3, 1e3}) {
    Arm arm = stanford();
    for (DhRow& row : arm.rows) {
      row.a *= size, row.d *= size;
      if (row.prismatic) row.least *= size, row.greatest *= size;
    }
    const KinematicMap map = kinematic_map(arm);
    InverseKinematics solver(map);
    Random random(15);
    for (int i = 0; i < 50; ++i)
      EXPECT_EQ(solver.solve(tool_pose(arm, random_joints(random, map))).outcome, PoseOutcome::kReached);
  }
}

TEST(InverseKinematics, ReachesWithOneJointWithSlidesAndWithAWristAlone) {
  const Arm one{.name = "one", .rows = {{.a = 0.5, .alpha = 0.3, .d = 0.2}}};
  const Arm slides{
      .name = "slides",
      .rows = {{.alpha = -0.5 * kPi, .prismatic = true, .least = 0.0, .greatest = 1.0},
               {.alpha = 0.5 * kPi, .theta = 0.5 * kPi, .prismatic = true, .least = 0.0, .greatest = 2.0},
               {.prismatic = true, .least = -1.0, .greatest = 1.0}}};
  const Arm wrist{
      .name = "wrist", .rows = {{.alpha = 0.5 * kPi}, {.alpha = -0.5 * kPi}, {}}, .task = {3, 4, 5}};
  for (const Arm& arm : {one, slides, wrist}) {
    const KinematicMap map = kinematic_map(arm);
    InverseKinematics solver(map);
    Random random(16);
    for (int i = 0; i < 200; ++i) {
      const Pose target = tool_pose(arm, random_joints(random, map));
      const InverseKinematicsResult result = solver.solve(target);
      EXPECT_EQ(result.outcome, PoseOutcome::kReached) << arm.name;
      EXPECT_LT(pose_distance(arm, result.q, target), 1e-10);
    }
  }
}

TEST_P(EveryArm, ReachesTheCornersOfItsLimitsAndStaysWhereItIs) {
  InverseKinematics solver(map);
  for (int corner = 0; corner < 1 << map.joints(); ++corner) {
    VectorXd q = map.least;
    for (int i = 0; i < q.size(); ++i)
      if (corner >> i & 1) q[i] = map.greatest[i];
    const Pose target = tool_pose(arm, q);
    EXPECT_EQ(solver.solve(target).outcome, PoseOutcome::kReached) << corner;
    const InverseKinematicsResult there = solver.solve(target, q);
    EXPECT_EQ(there.outcome, PoseOutcome::kReached);
    EXPECT_EQ(there.iterations, 0);
    EXPECT_EQ(there.q, q);
  }
}

TEST(InverseKinematics, TurnsTheToolByHalfATurn) {
  const Arm arm = ur5();
  const KinematicMap map = kinematic_map(arm);
  InverseKinematics solver(map);
  Random random(17);
  for (int i = 0; i < 100; ++i) {
    const VectorXd q = random_joints(random, map);
    VectorXd turned = q;
    turned[5] += q[5] > 0.0 ? -kPi : kPi;
    const Pose target = tool_pose(arm, turned);
    EXPECT_NEAR(rotation_vector(target.rotation * tool_pose(arm, q).rotation.transpose()).norm(), kPi, 1e-7);
    const InverseKinematicsResult result = solver.solve(target, q);
    EXPECT_EQ(result.outcome, PoseOutcome::kReached);
    EXPECT_LT(pose_distance(arm, result.q, target), 1e-10);
  }
}

TEST(InverseKinematics, IsTheSameEveryTime) {
  const Arm arm = panda();
  Random random(12);
  InverseKinematics first(kinematic_map(arm)), second(kinematic_map(arm));
  for (int i = 0; i < 20; ++i) {
    const Pose target = tool_pose(arm, random_joints(random, first.map()));
    const InverseKinematicsResult a = first.solve(target), b = second.solve(target);
    EXPECT_TRUE(a.q == b.q);
    EXPECT_EQ(a.iterations, b.iterations);
  }
}

TEST(InverseKinematics, RefusesBadInput) {
  InverseKinematics solver(kinematic_map(ur5()));
  const Pose fine;
  EXPECT_THROW((void)solver.solve({Matrix3d::Identity(), {0.1, std::nan(""), 0.0}}), InputError);
  EXPECT_THROW((void)solver.solve({2.0 * Matrix3d::Identity(), {0.1, 0.0, 0.0}}), InputError);
  EXPECT_THROW((void)solver.solve({-Matrix3d::Identity(), {0.1, 0.0, 0.0}}), InputError);
  EXPECT_THROW((void)solver.solve(fine, VectorXd::Constant(6, 7.0)), InputError);
  EXPECT_THROW((void)solver.solve(fine, VectorXd::Constant(5, 0.0)), MisuseError);
  EXPECT_THROW(InverseKinematics(kinematic_map(ur5()), {.tolerance = 0.0}), InputError);
  EXPECT_THROW(InverseKinematics(kinematic_map(ur5()), {.most_starts = 0}), InputError);
  EXPECT_TRUE(test::refused("|R R^T - E| of the target = 5.19", [&] {
    (void)solver.solve({2.0 * Matrix3d::Identity(), {0.1, 0.0, 0.0}});
  }));
  EXPECT_TRUE(test::refused("no reflection", [&] {
    (void)solver.solve({-Matrix3d::Identity(), {0.1, 0.0, 0.0}});
  }));
  // so far that the square of the error is no number
  EXPECT_TRUE(test::refused("distance of the target = 1e+160 m", [&] {
    (void)solver.solve({Matrix3d::Identity(), {1e160, 0.0, 0.0}});
  }));
  const InverseKinematicsResult far = solver.solve({Matrix3d::Identity(), {1e99, 0.0, 0.0}});
  EXPECT_TRUE(far.proved);
  EXPECT_NEAR(far.error.place / 1e99, 1.0, 1e-9);
}

// Where the tolerance is rounding, "unreachable" would be the tolerance's fault.
TEST(InverseKinematics, RefusesAToleranceThatRoundingCannotKeep) {
  const Arm arm = planar_2r(1e7, 1e7);
  EXPECT_TRUE(test::refused("m and rad, expected at least what rounding leaves, 7.11e-08",
                            [&] { InverseKinematics{kinematic_map(arm)}; }));
  const KinematicMap map = kinematic_map(arm);
  InverseKinematics solver(map, {.tolerance = 1e-7});
  Random random(18);
  for (int i = 0; i < 200; ++i)
    EXPECT_EQ(solver.solve(tool_pose(arm, random_joints(random, map))).outcome, PoseOutcome::kReached);
}

TEST(Settle, MovesToTheMiddleOfTheLimitsWithoutMovingTheTool) {
  const Arm arm = panda();
  const KinematicMap map = kinematic_map(arm);
  InverseKinematics solver(map);
  Random random(13);
  for (const Preference which : {Preference::kMiddle, Preference::kManipulability}) {
    double gained = 0.0;
    for (int i = 0; i < 5; ++i) {
      VectorXd q = random_joints(random, map);
      const Pose target = tool_pose(arm, q);
      const double before = preference(map, 1.0, which, q);
      ASSERT_TRUE(settle(map, target, q, {.which = which}).ok());
      EXPECT_LT(pose_distance(arm, q, target), 2e-11);
      EXPECT_TRUE(within_limits(map, q));
      const double after = preference(map, 1.0, which, q);
      EXPECT_GE(after, before);
      gained = std::max(gained, after - before);
    }
    EXPECT_GT(gained, 1e-2);
  }
}

TEST(Settle, StaysWhereNothingIsFree) {
  const Arm arm = puma560();
  const KinematicMap map = kinematic_map(arm);
  VectorXd q{{0.3, 0.5, -0.4, 0.6, 0.8, -0.2}};
  const VectorXd before = q;
  ASSERT_TRUE(settle(map, tool_pose(arm, q), q).ok());
  EXPECT_LT((q - before).norm(), 1e-9);
  EXPECT_EQ(settle(map, Pose{}, q).code, StatusCode::kRefused);
  EXPECT_THROW((void)settle(map, tool_pose(arm, q), q, {.length = -1.0}), InputError);
  EXPECT_THROW((void)settle(map, tool_pose(arm, q), q, {.tolerance = 0.0}), InputError);
}

// ---- The campaign: targets sampled within the limits (1 % of them with every test)

double at_fraction(std::vector<double> values, double fraction) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(fraction * static_cast<double>(values.size() - 1))];
}

TEST(InverseKinematicsCampaign, ReachesWhatTheArmsReach) {
  const int targets = test::campaign_cases(100000);
  for (const ArmInfo& info : arm_list()) {
    const Arm arm = info.make();
    const KinematicMap map = kinematic_map(arm);
    InverseKinematics solver(map);
    Random random(14);
    int reached = 0;
    std::vector<double> iterations, microseconds;
    for (int i = 0; i < targets; ++i) {
      const Pose target = tool_pose(arm, random_joints(random, map));
      const auto start = std::chrono::steady_clock::now();
      const InverseKinematicsResult result = solver.solve(target);
      const std::chrono::duration<double, std::micro> time = std::chrono::steady_clock::now() - start;
      iterations.push_back(result.iterations);
      microseconds.push_back(time.count());
      ASSERT_TRUE(within_limits(map, result.q));
      reached += result.outcome == PoseOutcome::kReached && pose_distance(arm, result.q, target) < 1e-10;
    }
    EXPECT_EQ(reached, targets) << info.name;
    std::printf("%-10s %d of %d reached, median %.0f iterations (90 %%: %.0f), %.1f us (90 %%: %.1f)\n",
                info.name.c_str(), reached, targets, at_fraction(iterations, 0.5),
                at_fraction(iterations, 0.9), at_fraction(microseconds, 0.5), at_fraction(microseconds, 0.9));
  }
}

}  // namespace
}  // namespace feder
