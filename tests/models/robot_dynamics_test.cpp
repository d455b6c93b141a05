// Arms as bodies: where they stand, how they move, and the torques it takes, against the engine's own rows.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "engine/check.h"
#include "engine/joints.h"
#include "engine/kkt.h"
#include "engine/row_rates.h"
#include "models/robot/arms.h"
#include "models/robot/links.h"
#include "models/robot_arm.h"
#include "tests/support/random.h"

namespace feder {
namespace {

VectorXd random_joints(Random& random, const Arm& arm) {
  VectorXd q(arm.joints());
  for (int i = 0; i < arm.joints(); ++i) q[i] = random.uniform(arm.rows[i].least, arm.rows[i].greatest);
  return q;
}

double distance(const Pose& a, const Pose& b) {
  return (homogeneous(a) - homogeneous(b)).norm();
}

class ArmAsBodies : public testing::TestWithParam<std::string> {
 protected:
  const Arm arm = make_arm(GetParam());
  const std::vector<MassProperties> links = link_bodies(arm);
  Random random{1};
};
std::vector<std::string> names() {
  std::vector<std::string> list;
  for (const ArmInfo& info : arm_list()) list.push_back(info.name);
  return list;
}
std::string name_of(const testing::TestParamInfo<std::string>& info) {
  return info.param;
}
INSTANTIATE_TEST_SUITE_P(Arms, ArmAsBodies, testing::ValuesIn(names()), name_of);

TEST_P(ArmAsBodies, StandsWhereForwardKinematicsSays) {
  for (int k = 0; k < 10; ++k) {
    const VectorXd q = random_joints(random, arm);
    SystemBuilder builder;
    const ArmBodies bodies = add_arm(builder, arm, links, q, VectorXd::Zero(arm.joints()));
    const auto [system, state] = builder.build();
    const std::vector<Pose> poses = link_frames(system, bodies, state.q), table = frames(arm, q);
    for (int i = 0; i < arm.joints(); ++i) EXPECT_LT(distance(poses[i], table[i + 1]), 1e-12);  // 2e-15
    EXPECT_LT(distance(product(poses.back(), arm.tool), tool_pose(arm, q)), 1e-12);
    // and back from the bodies to the joints
    EXPECT_LT((joint_values(arm, poses, q) - q).norm(), 1e-12);
    const VectorXd off = q + random.numbers(arm.joints(), 1.0);
    EXPECT_LT((joint_values(arm, poses, off) - q).norm(), 1e-12);
    VectorXd phi;
    evaluate_phi(system, state.q, phi);
    EXPECT_LT(phi.cwiseAbs().maxCoeff(), 1e-14);
  }
}

TEST_P(ArmAsBodies, MovesAsTheJacobianSays) {
  for (int k = 0; k < 10; ++k) {
    const VectorXd q = random_joints(random, arm), speeds = random.numbers(arm.joints());
    SystemBuilder builder;
    const ArmBodies bodies = add_arm(builder, arm, links, q, speeds);
    const auto [system, state] = builder.build();
    Anchor tool = bodies.links.back();
    tool.point = arm.tool.position;
    Eigen::Matrix<double, 6, 1> twist;
    twist << velocity(system, tool, state), angular_velocity(system.bodies.back(), state);
    ASSERT_GT(twist.norm(), 1e-2);
    EXPECT_LT((twist - tool_jacobian(arm, q) * speeds).norm(), 1e-13);
    // the joints allow these velocities
    Kkt kkt;
    kkt.prepare(system);
    kkt.set_step(1.0, 1.0);
    ASSERT_TRUE(kkt.evaluate(state.q).ok());
    VectorXd rate;
    kkt.multiply_jacobian(state.v, rate);
    EXPECT_LT(rate.cwiseAbs().maxCoeff(), 1e-13);
  }
}

TEST_P(ArmAsBodies, MotionsAreTheDerivativesOfTheFrames) {
  const VectorXd q = random_joints(random, arm), speeds = random.numbers(arm.joints()),
                 more = random.numbers(arm.joints());
  auto at = [&](double t) {
    return link_motions(arm, q + t * speeds + 0.5 * t * t * more, speeds + t * more, more);
  };
  const double h = 1e-4;
  const auto now = at(0.0), before = at(-h), after = at(h);
  for (int i = 0; i < arm.joints(); ++i) {
    const Vector3d velocity = (after[i].frame.position - before[i].frame.position) / (2.0 * h);
    const Vector3d acceleration = (after[i].velocity - before[i].velocity) / (2.0 * h);
    const Vector3d turning_rate = (after[i].turning - before[i].turning) / (2.0 * h);
    EXPECT_LT((velocity - now[i].velocity).norm(), 1e-6);
    EXPECT_LT((acceleration - now[i].acceleration).norm(), 1e-6);
    EXPECT_LT((turning_rate - now[i].turning_rate).norm(), 1e-6);
  }
}

// The multipliers of rigid motor rows: M a - J^T lambda = f, J a = -J' v - phi_tt.
VectorXd motor_torques(const System& s, const State& state, const std::vector<int>& rows) {
  Kkt kkt;
  kkt.prepare(s);
  kkt.set_step(0.0, 0.0);
  EXPECT_TRUE(kkt.evaluate(state.q).ok());
  const int n = 3 * s.nodes;
  Eigen::MatrixXd J(s.rows, n), W = s.inverse_mass.asDiagonal();
  VectorXd column, rates, f, driven(n);
  for (int i = 0; i < n; ++i) {
    kkt.multiply_jacobian(VectorXd::Unit(n, i), column);
    J.col(i) = column;
  }
  jacobian_rate(s, state, rates);
  driven_accelerations(s, state.t, driven);
  EXPECT_TRUE(evaluate_forces(s, state, f).ok());
  add_gyroscopic_torques(s, state.v, f);
  std::vector<int> hard;
  for (int k = 0; k < s.rows; ++k)
    if (std::isinf(s.stiffness[k])) hard.push_back(k);
  const Eigen::MatrixXd H = J(hard, Eigen::all);
  const VectorXd right = -(rates + J * driven + J * (W * f))(hard);
  const VectorXd lambda = (H * W * H.transpose()).fullPivLu().solve(right);
  VectorXd torques(rows.size());
  for (int i = 0; i < torques.size(); ++i)
    torques[i] = lambda[std::find(hard.begin(), hard.end(), s.row_of_id[rows[i]]) - hard.begin()];
  return torques;
}

TEST_P(ArmAsBodies, TakesTheTorquesOfItsMotorRows) {
  const Vector3d gravity(0.3, -0.2, -9.81);
  for (int k = 0; k < 5; ++k) {
    const VectorXd q = random_joints(random, arm), speeds = random.numbers(arm.joints()),
                   more = random.numbers(arm.joints(), 3.0);
    SystemBuilder builder;
    const ArmBodies bodies = add_arm(builder, arm, links, q, speeds);
    builder.set_gravity(gravity);
    std::vector<int> motors;
    for (int i = 0; i < arm.joints(); ++i) {
      const Target target{[](double) { return 0.0; }, [v = speeds[i]](double) { return v; },
                          [a = more[i]](double) { return a; }};
      const Anchor before = i > 0 ? bodies.links[i - 1] : Anchor{};
      const LinkMotion& at = bodies.start[i];
      motors.push_back(arm.rows[i].prismatic
                           ? add_slide(builder, before, bodies.links[i], at.joint, at.axis, {kRigid}, target)
                           : add_turn(builder, before, bodies.links[i], at.axis, {kRigid}, target));
    }
    auto [system, state] = builder.build();
    drive(system, state);
    const VectorXd torques = motor_torques(system, state, motors);
    const VectorXd recursive = inverse_dynamics(arm, links, gravity, q, speeds, more);
    ASSERT_GT(recursive.norm(), 0.1);
    EXPECT_LT((torques - recursive).norm(), 1e-10 * recursive.norm());  // 4e-13
    // without the terms of speed they differ
    const VectorXd at_rest = inverse_dynamics(arm, links, gravity, q, 0.0 * speeds, more);
    if (arm.joints() > 2) EXPECT_GT((torques - at_rest).norm(), 1e-3 * recursive.norm());
  }
}

TEST(PumaLinks, AreBodiesAfterOneChangeToThePublishedMoments) {
  const MassProperties published{4.8, {-0.0203, -0.0141, 0.070}, Vector3d(0.066, 0.086, 0.0125).asDiagonal()};
  EXPECT_THROW(check_inertia("link 3 as published", published), InputError);
  for (const MassProperties& link : link_bodies(puma560())) EXPECT_NO_THROW(check_inertia("link", link));
}

// The gravity load of the PUMA's shoulder, written out: masses at their places, arm stretched along x.
TEST(PumaLinks, WeighOnTheShoulderWhatTheirMomentsSay) {
  const Arm arm = puma560();
  const VectorXd q = VectorXd::Zero(6), rest = VectorXd::Zero(6);
  const VectorXd torques = inverse_dynamics(arm, link_bodies(arm), {0.0, 0.0, -9.81}, q, rest, rest);
  const double x = 0.4318 + 0.0203;  // of the wrist, and of frame 3
  const double moment = 17.4 * (0.4318 - 0.3638) + 4.8 * (x - 0.0203) + (0.82 + 0.34 + 0.09) * x;
  EXPECT_NEAR(torques[1], 9.81 * moment, 1e-12);  // 37.48 N m
  EXPECT_NEAR(torques[0], 0.0, 1e-12);            // about the vertical
}

TEST(JointPath, StartsAndEndsAtRest) {
  const JointPath path{VectorXd{{0.0, 1.0}}, VectorXd{{2.0, -1.0}}, 2.0};
  for (const double t : {0.0, 2.0, 3.0}) {
    EXPECT_EQ(path.rate(t).norm(), 0.0);
    EXPECT_EQ(path.acceleration(t).norm(), 0.0);
  }
  EXPECT_EQ(path.value(0.0), path.start);
  EXPECT_LT((path.value(2.0) - path.goal).norm(), 1e-15);
  EXPECT_LT((path.value(1.0) - VectorXd{{1.0, 0.0}}).norm(), 1e-15);
  const double h = 1e-4;
  for (const double t : {0.3, 1.1}) {
    EXPECT_LT(((path.value(t + h) - path.value(t - h)) / (2.0 * h) - path.rate(t)).norm(), 1e-7);
    EXPECT_LT(((path.rate(t + h) - path.rate(t - h)) / (2.0 * h) - path.acceleration(t)).norm(), 1e-7);
  }
}

}  // namespace
}  // namespace feder
