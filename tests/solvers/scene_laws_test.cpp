// What a scene prescribes by expressions is what a program prescribes by hand.
#include <gtest/gtest.h>

#include <cmath>

#include "engine/joints.h"
#include "models/scene_file/laws.h"
#include "solvers/simulate.h"

namespace feder {
namespace {

State run(const char* name, const SystemBuilder::Built& built, double dt, double end,
          std::vector<EnergyLedger>* ledgers = nullptr) {
  Integrator integrator = make_integrator(name, built.system);
  State state = built.state;
  History history;
  const RunResult result =
      simulate(built.system, integrator, state, history, {.dt = dt, .end_time = end, .ledgers = ledgers});
  EXPECT_TRUE(result.status.ok()) << name << ": " << result.status.reason;
  return state;
}

SystemBuilder::Built pendulum(const Motion& motion) {
  SystemBuilder builder;
  const Anchor hand = builder.add_moving_point(motion),
               bob = builder.add_particle(0.8, {0.6, -0.8, 0.0}, motion.velocity(0.0));
  builder.add_distance(hand, bob, {kRigid}, 1.0);
  builder.set_gravity({0.0, -9.81, 0.0});
  return builder.build();
}

TEST(SceneLaws, ADrivenPendulumIsThatOfTheHandWrittenMotion) {
  const auto own = pendulum(motion_from(std::array{
      Expression("0.2*sin(3*t)", {"t"}), Expression("0.1*(1 - cos(2*t))", {"t"}), Expression("0", {"t"})}));
  const auto hand =
      pendulum({[](double t) { return Vector3d(0.2 * std::sin(3 * t), 0.1 * (1 - std::cos(2 * t)), 0.0); },
                [](double t) { return Vector3d(0.6 * std::cos(3 * t), 0.2 * std::sin(2 * t), 0.0); },
                [](double t) { return Vector3d(-1.8 * std::sin(3 * t), 0.4 * std::cos(2 * t), 0.0); }});
  for (const char* name : {"implicit_euler_notes", "implicit_euler_newton", "leapfrog", "rk4"}) {
    const State a = run(name, own, 1e-3, 1.0), b = run(name, hand, 1e-3, 1.0);
    EXPECT_GT((b.q - hand.state.q).norm(), 0.1) << name;
    EXPECT_LT((a.q - b.q).norm(), 1e-13) << name;
    EXPECT_LT((a.v - b.v).norm(), 1e-12) << name;
  }
}

TEST(SceneLaws, AHardMotorFollowsAnExpression) {
  const Target target = target_from(Expression("2*t^2/(1 + t) + 0.3*sin(5*t)", {"t"}));
  SystemBuilder builder;
  const Anchor rotor = builder.add_body(solid_box("rotor", 1.2, {0.5, 0.3, 0.1}),
                                        {.angular_velocity = {0.0, 0.0, target.rate(0.0)}});
  add_hinge(builder, {}, rotor, Vector3d::Zero(), Vector3d::UnitZ());
  add_turn(builder, {}, rotor, Vector3d::UnitZ(), {kRigid}, target);
  const auto built = builder.build();
  const State end = run("implicit_euler_newton", built, 0.01, 2.0);
  const double turned = std::atan2(orientation(built.system.bodies[0], end.q)(1, 0),
                                   orientation(built.system.bodies[0], end.q)(0, 0));
  EXPECT_GT(target.value(2.0), 2.0);
  EXPECT_NEAR(std::remainder(turned - target.value(2.0), 2.0 * 3.14159265358979323846), 0.0, 1e-10);
}

TEST(SceneLaws, ASpringFromAnExpressionKeepsItsEnergy) {
  const SpringLaw law =
      law_from(Expression("30*(length - 0.4) + 500*(length - 0.4)^3", {"length", "rate"}), 0.4);
  SystemBuilder builder;
  builder.add_law_spring(
      {{builder.add_world_point({0.0, 0.0, 0.0}), builder.add_particle(1.0, {0.1, -0.6, 0.1})},
       law.law,
       law.energy});
  builder.set_gravity({0.0, -9.81, 0.0});
  const auto built = builder.build();
  std::vector<EnergyLedger> ledgers;
  const State end = run("rk4", built, 1e-3, 1.0, &ledgers);
  EXPECT_GT(kinetic_energy(built.system, end), 0.01);
  EXPECT_NEAR(total_energy(built.system, end), total_energy(built.system, built.state), 1e-7);
  ASSERT_FALSE(ledgers.empty());
  for (const EnergyLedger& ledger : ledgers)
    EXPECT_LT(std::abs(ledger.imbalance()), 1e-12 * ledger.magnitude() + 1e-15);
}

/// m x'' = -k x - c x' from rest at 1, damped below the limit.
TEST(SceneLaws, AForceFromExpressionsIsItsOscillator) {
  const double k = 40.0, c = 0.6, mass = 0.5, end = 1.0, decay = c / (2 * mass),
               pulse = std::sqrt(k / mass - decay * decay);
  SystemBuilder builder;
  builder.add_particle(mass, {1.0, 0.0, 0.0});
  builder.set_user_force(force_from({{{Expression("-40*x - 0.6*vx", kForceVariables),
                                       Expression("0", kForceVariables), Expression("0", kForceVariables)},
                                      {0}}}));
  const auto built = builder.build();
  const double exact =
      std::exp(-decay * end) * (std::cos(pulse * end) + decay / pulse * std::sin(pulse * end));
  EXPECT_NEAR(run("rk4", built, 1e-3, end).q[0], exact, 1e-9);
  const double coarse = run("implicit_euler_newton", built, 2e-4, end).q[0] - exact,
               fine = run("implicit_euler_newton", built, 1e-4, end).q[0] - exact;
  EXPECT_NEAR(coarse / fine, 2.0, 0.1);
}

}  // namespace
}  // namespace feder
