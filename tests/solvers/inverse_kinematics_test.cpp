// Inverse kinematics (notes F2, F3): steps within the joint limits, and whole solves over the catalogue of
// arms.
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

namespace feder {
namespace {

using Eigen::MatrixXd;
constexpr double kPi = std::numbers::pi;

VectorXd random_joints(Random& random, const KinematicMap& map) {
  VectorXd q(map.joints());
  for (int i = 0; i < q.size(); ++i) q[i] = random.uniform(map.least[i], map.greatest[i]);
  return q;
}

bool within_limits(const KinematicMap& map, const VectorXd& q) {
  return (q.array() >= map.least.array()).all() && (q.array() <= map.greatest.array()).all();
}

// ---- Steps

TEST(JointStep, ConvergesQuadratically) {
  const KinematicMap map = kinematic_map(puma560());
  const VectorXd goal{{0.3, 0.5, -0.4, 0.6, 0.8, -0.2}};
  Pose target;
  ToolJacobian J;
  map.evaluate(goal.data(), target, J);
  JointStep arm(map, 0.3);
  VectorXd q = goal + 0.1 * VectorXd{{1.0, -1.0, 1.0, -1.0, 1.0, -1.0}}, x;
  std::vector<double> error;
  for (int i = 0; i < 5; ++i) {
    arm.linearise(q, target);
    error.push_back(arm.error().norm());
    ASSERT_TRUE(arm.step(q, VectorXd::Zero(6), 0.0, x));
    arm.take(x, q);
  }
  ASSERT_GT(error[0], 0.03);
  for (int i = 1; i < 4; ++i) EXPECT_LT(error[i], 20.0 * error[i - 1] * error[i - 1]) << i;
  EXPECT_LT(error[4], 1e-14);
}

TEST(JointStep, HoldsJointsAtTheirLimitsAndSolvesTheOthersAgain) {
  const Arm arm = planar_nr(4);
  KinematicMap map = kinematic_map(arm);
  const VectorXd q{{0.3, 0.4, 0.5, 0.3}};
  map.greatest[1] = 0.41, map.least[2] = 0.45;
  Pose target;
  ToolJacobian J;
  map.evaluate(VectorXd{{0.3, 0.45, 0.6, 0.2}}.data(), target, J);
  JointStep step(map, 1.0);
  step.linearise(q, target);
  VectorXd x;
  ASSERT_TRUE(step.step(q, VectorXd::Zero(4), 0.0, x));
  EXPECT_GT(step.solves(), 1);
  EXPECT_TRUE(within_limits(map, q + x));
  // the linear task is still met exactly, which clipping the first step would not do
  EXPECT_LT((step.matrix() * x - step.error()).norm(), 1e-15);
  VectorXd clipped = minimum_norm_step(step.matrix(), step.error());
  clipped = (q + clipped).cwiseMax(map.least).cwiseMin(map.greatest) - q;
  EXPECT_GT((step.matrix() * clipped - step.error()).norm(), 1e-3);
}

TEST(JointStep, TurnsComeInAgainFromTheOtherSideAndSlidesStop) {
  Arm arm = planar_2r();
  arm.rows.push_back({.prismatic = true, .least = -5.0, .greatest = 5.0});
  const KinematicMap map = kinematic_map(arm);
  const JointStep step(map, 1.0);
  VectorXd q{{3.0, -3.0, 4.9}};
  const Pose before = tool_pose(arm, q + VectorXd{{0.5, -0.5, 0.1}});
  step.take(VectorXd{{0.5, -0.5, 0.5}}, q, JointStep::AtLimits::kWrap);
  EXPECT_NEAR(q[0], 3.5 - 2.0 * kPi, 1e-15);
  EXPECT_NEAR(q[1], 2.0 * kPi - 3.5, 1e-15);
  EXPECT_EQ(q[2], 5.0);
  EXPECT_LT((tool_pose(arm, q).position - before.position).norm(), 1e-14);
  VectorXd stopped{{3.0, -3.0, 4.9}};
  step.take(VectorXd{{0.5, -0.5, 0.5}}, stopped);
  EXPECT_EQ(stopped, VectorXd({{kPi, -kPi, 5.0}}));
}

TEST(JointStep, MovesInTheNullSpaceAlongZ) {
  const KinematicMap map = kinematic_map(panda());
  Random random(7);
  const VectorXd q = 0.5 * (map.least + map.greatest), z = random.numbers(7, 0.01);
  Pose here;
  ToolJacobian J;
  map.evaluate(q.data(), here, J);
  JointStep step(map, 0.5);
  step.linearise(q, here);
  VectorXd x;
  ASSERT_TRUE(step.step(q, z, 0.0, x));
  ASSERT_GT(x.norm(), 1e-4);
  EXPECT_LT((step.matrix() * x).norm(), 1e-15);
  const MatrixXd& A = step.matrix();
  EXPECT_LT((x - (z - pseudo_inverse(A) * (A * z))).norm(), 1e-15);
}

TEST(RotationVector, IsExactFromTinyToHalfTurns) {
  Random random(8);
  for (const double angle : {1e-12, 1e-6, 0.1, 1.0, 3.0, kPi - 1e-6}) {
    const Vector3d axis = random.vector().normalized();
    const Vector3d back = rotation_vector(Eigen::AngleAxisd(angle, axis).toRotationMatrix());
    EXPECT_LT((back - angle * axis).norm(), 1e-15 + 1e-14 * angle) << angle;
  }
  EXPECT_EQ(rotation_vector(Matrix3d::Identity()).norm(), 0.0);
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
    EXPECT_GE(reached, 0.999 * targets) << info.name;  // all of 100000 on every arm
    std::printf("%-10s %d of %d reached, median %.0f iterations (90 %%: %.0f), %.1f us (90 %%: %.1f)\n",
                info.name.c_str(), reached, targets, at_fraction(iterations, 0.5),
                at_fraction(iterations, 0.9), at_fraction(microseconds, 0.5), at_fraction(microseconds, 0.9));
  }
}

}  // namespace
}  // namespace feder
