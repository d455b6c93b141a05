// One step of an arm (notes F3, F4): quadratic convergence, joint limits, the null space.
#include "solvers/joint_step.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "models/robot/arms.h"
#include "tests/support/random.h"

namespace feder {
namespace {

using Eigen::MatrixXd;
constexpr double kPi = std::numbers::pi;

bool within_limits(const KinematicMap& map, const VectorXd& q) {
  return (q.array() >= map.least.array()).all() && (q.array() <= map.greatest.array()).all();
}

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

TEST(FreeGradient, LeavesOutWhatLimitsHold) {
  const KinematicMap map = kinematic_map(planar_2r(1.0, 1.0));
  JointStep step(map, 1.0);
  VectorXd q{{0.2, map.greatest[1]}};
  // target beside the tool: one direction draws the second joint out of its limit, the other back in
  Pose tool = tool_pose(planar_2r(1.0, 1.0), q);
  for (const double way : {0.1, -0.1}) {
    Pose target = tool;
    target.position +=
        way * Vector3d(std::cos(0.2 + q[1] + 0.5 * kPi), std::sin(0.2 + q[1] + 0.5 * kPi), 0.0);
    step.linearise(q, target);
    const VectorXd slope = step.matrix().transpose() * step.error();
    ASSERT_GT(way * slope[1], 1e-3);
    const double first = slope[0] * slope[0], both = slope.squaredNorm();
    EXPECT_NEAR(step.free_gradient(q), way > 0.0 ? first : both, 1e-15);
    // a full turn has no end where it wraps
    EXPECT_NEAR(step.free_gradient(q, JointStep::AtLimits::kWrap), both, 1e-15);
  }
}

}  // namespace
}  // namespace feder
