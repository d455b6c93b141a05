// Arms of bodies led along a path of their joints: motors hold it exactly, PD gives way under the load,
// computed torque lags by the step.
#include "models/robot_arm.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/energy.h"
#include "models/robot/arms.h"
#include "models/robot/links.h"
#include "solvers/simulate.h"

namespace feder {
namespace {

struct Tracked {
  Status status;
  double worst = 0.0, end = 0.0;  // of a joint against the path, over the run and at its end [rad], [m]
  double poses = 0.0;             // links against forward kinematics of the joints as they stand, at the end
  double moved = 0.0;             // of the joints
};

Tracked run(const RobotArm& o, const char* integrator_name, double dt) {
  const Arm arm = arm_list()[static_cast<std::size_t>(o.arm)].make();
  const Model model = make_robot_arm(o);
  const JointPath path = path_of(o);
  ArmBodies bodies;
  for (int i = 0; i < arm.joints(); ++i) bodies.links.push_back({.body = i});
  Tracked tracked;
  auto joints = [&](const State& at) {
    return joint_values(arm, link_frames(model.system, bodies, at.q), path.value(at.t));
  };
  Integrator integrator = make_integrator(integrator_name, model.system);
  State state = model.state;
  History history;
  tracked.status = simulate(model.system, integrator, state, history,
                            {.dt = dt,
                             .end_time = model.end_time,
                             .observer =
                                 [&](const State& at, const History&) {
                                   const VectorXd off = joints(at) - path.value(at.t);
                                   tracked.worst = std::max(tracked.worst, off.lpNorm<Eigen::Infinity>());
                                   return true;
                                 }})
                       .status;
  const VectorXd q = joints(state);
  tracked.end = (q - path.value(state.t)).lpNorm<Eigen::Infinity>();
  tracked.moved = (q - path.start).norm();
  const std::vector<Pose> stand = link_frames(model.system, bodies, state.q), table = frames(arm, q);
  for (int i = 0; i < arm.joints(); ++i)
    tracked.poses = std::max(tracked.poses, (homogeneous(stand[i]) - homogeneous(table[i + 1])).norm());
  return tracked;
}

class LedArm : public testing::TestWithParam<int> {};
std::vector<int> places() {
  std::vector<int> list;
  for (int i = 0; i < std::ssize(arm_list()); ++i) list.push_back(i);
  return list;
}
std::string name_of(const testing::TestParamInfo<int>& info) {
  return arm_list()[static_cast<std::size_t>(info.param)].name;
}
INSTANTIATE_TEST_SUITE_P(Arms, LedArm, testing::ValuesIn(places()), name_of);

TEST_P(LedArm, MotorsHoldThePathAndTheTable) {
  RobotArm o;
  o.arm = GetParam(), o.control = ArmControl::kMotors;
  const Tracked t = run(o, "implicit_euler_newton", 5e-3);
  ASSERT_TRUE(t.status.ok()) << t.status.reason;
  EXPECT_GT(t.moved, 0.5);
  EXPECT_LT(t.worst, 1e-12);  // 1e-15
  EXPECT_LT(t.poses, 1e-12);  // 1e-15
}

TEST_P(LedArm, PdGivesWayUnderTheLoadByTheSquareOfItsFrequency) {
  RobotArm soft, hard;
  soft.arm = hard.arm = GetParam();
  soft.frequency = 40.0, hard.frequency = 160.0;
  const Tracked a = run(soft, "implicit_euler_newton", 2e-3), b = run(hard, "implicit_euler_newton", 2e-3);
  ASSERT_TRUE(a.status.ok() && b.status.ok()) << a.status.reason << b.status.reason;
  EXPECT_GT(a.moved, 0.5);
  EXPECT_GT(a.worst, 10.0 * b.worst);  // 15.6 to 17.7
  EXPECT_LT(a.worst, 0.1);             // 0.008 to 0.068
  EXPECT_LT(a.poses, 1e-9);
}

TEST_P(LedArm, ComputedTorqueFollowsAtTheOrderOfTheIntegrator) {
  RobotArm o;
  o.arm = GetParam(), o.control = ArmControl::kComputedTorque;
  const Tracked coarse = run(o, "rk4", 4e-3), fine = run(o, "rk4", 2e-3);
  ASSERT_TRUE(coarse.status.ok() && fine.status.ok()) << coarse.status.reason << fine.status.reason;
  EXPECT_GT(fine.moved, 0.5);
  EXPECT_LT(fine.worst, 1e-7);                 // 1.9e-9 to 2.6e-8
  EXPECT_GT(coarse.worst, 12.0 * fine.worst);  // 17
}

TEST(LedPuma, FollowsComputedTorqueAtFirstOrderUnderImplicitEuler) {
  RobotArm o;
  o.control = ArmControl::kComputedTorque;
  const Tracked coarse = run(o, "implicit_euler_newton", 4e-3), fine = run(o, "implicit_euler_newton", 2e-3);
  ASSERT_TRUE(coarse.status.ok() && fine.status.ok()) << coarse.status.reason << fine.status.reason;
  EXPECT_LT(fine.worst, 1e-3);  // 2.9e-4
  EXPECT_NEAR(coarse.worst / fine.worst, 2.0, 0.3);
}

TEST(LedPuma, KeepsItsEnergyWhereNothingLeadsIt) {
  RobotArm o;
  o.control = ArmControl::kLoose;
  const Model model = make_robot_arm(o);
  ASSERT_EQ(model.conserved.size(), 1u);
  Integrator integrator = make_integrator("rk4", model.system);
  State state = model.state;
  History history;
  const RunResult result = simulate(model.system, integrator, state, history, {.dt = 1e-3, .end_time = 0.5});
  ASSERT_TRUE(result.status.ok()) << result.status.reason;
  const Conserved& energy = model.conserved[0];
  const double fallen = kinetic_energy(model.system, state);
  ASSERT_GT(fallen, 1.0);
  EXPECT_LT(std::abs(energy.value(model.system, state) - energy.value(model.system, model.state)),
            1e-9 * fallen);  // 5e-11
}

}  // namespace
}  // namespace feder
