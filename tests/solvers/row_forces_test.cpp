// What rows pull with at a state, against closed forms, and RK4's refusal to go on with open rows.
#include <gtest/gtest.h>

#include <cmath>

#include "engine/joints.h"
#include "engine/kkt.h"
#include "models/catalog.h"
#include "models/pendulum.h"
#include "solvers/simulate.h"

namespace feder {
namespace {

VectorXd row_forces(const System& system, const State& state) {
  Rk4 rk4(system, {});
  EXPECT_TRUE(rk4.prepare().ok());
  VectorXd lambda;
  const Status status = rk4.row_forces(state, lambda);
  EXPECT_TRUE(status.ok()) << status.reason;
  return lambda;
}

TEST(RowForces, RodOfAPendulumCarriesWeightAndCentripetalForce) {
  const Pendulum options{.mass = 2.0, .length = 1.5, .angle = 2.0};
  const Model model = make_pendulum(options);
  ASSERT_TRUE(model.system.has_hard_rows);
  for (double t : {0.0, 0.3, 0.9}) {
    const State state = model.exact(t);
    // m g (3 cos theta - 2 cos theta_0), theta from hanging
    const double cosine = -state.q.segment<3>(3).dot(Vector3d::UnitY()) / options.length;
    const double tension = options.mass * options.gravity * (3.0 * cosine - 2.0 * std::cos(options.angle));
    EXPECT_NEAR(row_forces(model.system, state)[0], -tension, 1e-11) << t;  // 1.8e-14
  }
}

// A bar turned at a steady rate against its weight, with a torsion spring beside the motor.
SystemBuilder::Built motor(double start) {
  SystemBuilder builder;
  const Anchor bar =
      builder.add_body(solid_box("bar", 3.0, {0.8, 0.1, 0.1}),
                       {.position = {0.4, 0, 0}, .velocity = {0, 0.8, 0}, .angular_velocity = {0, 0, 2}});
  add_hinge(builder, {}, bar, Vector3d::Zero(), Vector3d::UnitZ());
  add_turn(builder, {}, bar, Vector3d::UnitZ(), {kRigid}, steady_target(start, 2.0));
  add_turn(builder, {}, bar, Vector3d::UnitZ(), {.stiffness = 5.0, .damping = 0.5}, 0.25);
  builder.set_gravity({0, -9.81, 0});
  return builder.build();
}

TEST(RowForces, MotorHoldsTheWeightAndTheSpringBesideIt) {
  auto [system, state] = motor(0.0);
  ASSERT_EQ(system.row_of_id.size(), 5u);  // ball, two perpendicular, motor, spring
  Integrator rk4 = make_integrator("rk4", system);
  History history;
  ASSERT_TRUE(simulate(system, rk4, state, history, {.dt = 1e-3, .end_time = 0.3}).status.ok());
  const VectorXd lambda = row_forces(system, state);
  const double angle = 0.6, spring = -5.0 * (angle - 0.25) - 0.5 * 2.0;
  EXPECT_NEAR(lambda[system.row_of_id[4]], spring, 1e-10);                                      // 1e-13
  EXPECT_NEAR(lambda[system.row_of_id[3]], 3.0 * 9.81 * 0.4 * std::cos(angle) - spring, 1e-9);  // 1e-12
}

TEST(RowForces, AreThoseOfASmallImplicitStep) {
  const Model model = make_model("flexible_linkage");
  State state = model.state;
  Integrator newton = make_integrator("implicit_euler_newton", model.system);
  History history;
  ASSERT_TRUE(simulate(model.system, newton, state, history, {.dt = 1e-5, .end_time = 1e-3}).status.ok());
  const VectorXd lambda = row_forces(model.system, state);
  const double largest = lambda.cwiseAbs().maxCoeff();
  ASSERT_GT(largest, 1.0);
  EXPECT_LT((lambda - history.lambda).cwiseAbs().maxCoeff(), 0.02 * largest);
}

TEST(Rk4, FailsByNameWhereAMotorStartsOutOfReach) {
  auto [system, state] = motor(10.0);
  Integrator rk4 = make_integrator("rk4", system);
  History history;
  const RunResult result = simulate(system, rk4, state, history, {.dt = 1e-2, .end_time = 0.1});
  EXPECT_EQ(result.status.code, StatusCode::kNotConverged);
  EXPECT_NE(result.status.reason.find("turn row 3"), std::string::npos) << result.status.reason;
}

}  // namespace
}  // namespace feder
