// Prescribed motions, motors and dampers under every integrator.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "engine/joints.h"
#include "solvers/ida_reference.h"
#include "solvers/simulate.h"

namespace feder {
namespace {

constexpr double kPi = std::numbers::pi;

State run(const char* name, const System& system, const State& start, double dt, double end) {
  Integrator integrator = make_integrator(name, system);
  State state = start;
  History history;
  const RunResult result = simulate(system, integrator, state, history, {.dt = dt, .end_time = end});
  EXPECT_TRUE(result.status.ok()) << name << ": " << result.status.reason;
  return state;
}

Target shaken() {
  return {[](double t) { return 0.8 * std::sin(3.0 * t); }, [](double t) { return 2.4 * std::cos(3.0 * t); },
          [](double t) { return -7.2 * std::sin(3.0 * t); }};
}

/// A rotor on a soft damped bearing with a soft motor, a particle on a spring from a moving hand, a damper.
SystemBuilder::Built driven_scene() {
  SystemBuilder builder;
  const Anchor rotor = builder.add_body(solid_box("rotor", 1.2, {0.5, 0.3, 0.1}), {});
  add_hinge(builder, {}, rotor, Vector3d::Zero(), Vector3d::UnitZ(),
            {.linear = {200.0, 0.01}, .angular = {20.0, 0.02}});
  add_turn(builder, {}, rotor, Vector3d::UnitZ(), {5.0, 0.0, 0.1}, shaken());
  const Anchor hand =
      builder.add_moving_point({[](double t) { return Vector3d(0.2 * std::sin(2.0 * t), 1.0, 0.0); },
                                [](double t) { return Vector3d(0.4 * std::cos(2.0 * t), 0.0, 0.0); },
                                [](double t) { return Vector3d(-0.8 * std::sin(2.0 * t), 0.0, 0.0); }});
  const Anchor bob = builder.add_particle(0.5, {0.1, 0.4, 0.2});
  builder.add_distance(hand, bob, {30.0, 0.0, 0.2}, 0.5);
  builder.add(AnchorDistanceRow{{{.body = rotor.body, .point = {0.25, 0.0, 0.0}}, bob, 0.0, 0.0, 0.3}, 0.1});
  builder.set_gravity({0.0, -9.81, 0.0});
  return builder.build();
}

TEST(Drives, KeepTheOrderOfEveryIntegrator) {
  const auto [s, start] = driven_scene();
  constexpr double kEnd = 0.5;
  const State exact = run("rk4", s, start, 2.5e-5, kEnd);
  ASSERT_GT((exact.q - start.q).norm(), 0.1);
  auto error = [&](const State& state) {
    return (state.q.head(3 * s.places()) - exact.q.head(3 * s.places())).norm() +
           (orientation(s.bodies[0], state.q) - orientation(s.bodies[0], exact.q)).norm();
  };
  for (const IntegratorInfo& method : integrator_list()) {
    const double dt = method.order == 4 ? 4e-3 : method.order == 2 ? 1e-3 : 1e-4;
    const double coarse = error(run(method.name, s, start, dt, kEnd)),
                 fine = error(run(method.name, s, start, 0.5 * dt, kEnd));
    EXPECT_NEAR(std::log2(coarse / fine), method.order, 0.1) << method.name << " " << coarse << " " << fine;
  }
}

TEST(Drives, NewtonLedgerClosesWhenDrivesDoWork) {
  const auto [s, start] = driven_scene();
  for (const char* name : {"implicit_euler_notes", "implicit_euler_geometric", "implicit_euler_newton"}) {
    Integrator integrator = make_integrator(name, s);
    State state = start;
    History history;
    std::vector<EnergyLedger> ledgers;
    ASSERT_TRUE(simulate(s, integrator, state, history, {.dt = 0.01, .end_time = 0.5, .ledgers = &ledgers})
                    .status.ok());
    for (const EnergyLedger& ledger : ledgers)
      EXPECT_LT(std::abs(ledger.imbalance()), 1e-12 * ledger.magnitude()) << name;
  }
}

/// m x'' = -k (x - a sin(w t)) from rest: x = a w0^2/(w0^2 - w^2) (sin w t - w/w0 sin w0 t).
TEST(Drives, ForcedOscillatorIsExactUnderTheJudge) {
  constexpr double kMass = 0.7, kSpring = 30.0, kWay = 0.1, kPulse = 4.0, kEnd = 1.3;
  SystemBuilder builder;
  const Anchor hand = builder.add_moving_point(
      {[](double t) { return Vector3d(kWay * std::sin(kPulse * t), 0.0, 0.0); },
       [](double t) { return Vector3d(kWay * kPulse * std::cos(kPulse * t), 0.0, 0.0); },
       [](double t) { return Vector3d(-kWay * kPulse * kPulse * std::sin(kPulse * t), 0.0, 0.0); }});
  builder.add_distance(hand, builder.add_particle(kMass, {2.0, 0.0, 0.0}), {kSpring}, 2.0);
  const auto [s, start] = builder.build();
  const double own = std::sqrt(kSpring / kMass);
  const double exact = 2.0 + kWay * own * own / (own * own - kPulse * kPulse) *
                                 (std::sin(kPulse * kEnd) - kPulse / own * std::sin(own * kEnd));
  ASSERT_GT(std::abs(exact - 2.0), 0.01);
  const IdaResult judge = ida_solve(s, start, kEnd);
  ASSERT_TRUE(judge.status.ok()) << judge.status.reason;
  EXPECT_NEAR(judge.state.q[3], exact, 1e-7);  // 1.7e-8
  EXPECT_NEAR(run("rk4", s, start, 1e-3, kEnd).q[3], exact, 1e-9);
}

/// A hard motor turns a rotor about a hinge: the angle is the target's, over several turns.
SystemBuilder::Built motor(const Target& target) {
  SystemBuilder builder;
  const Anchor rotor = builder.add_body(solid_box("rotor", 1.2, {0.5, 0.3, 0.1}),
                                        {.position = {0.1, 0.0, 0.0},
                                         .velocity = target.rate(0.0) * Vector3d(0.0, 0.1, 0.0),
                                         .angular_velocity = {0.0, 0.0, target.rate(0.0)}});
  add_hinge(builder, {}, rotor, Vector3d::Zero(), Vector3d::UnitZ());
  add_turn(builder, {}, rotor, Vector3d::UnitZ(), {kRigid}, target);
  builder.set_gravity({0.0, -9.81, 0.0});
  return builder.build();
}

TEST(Motor, HoldsItsAngleOverManyTurns) {
  const auto [s, start] = motor(steady_target(0.0, 20.0));
  const TurnRow& row = std::get<std::vector<TurnRow>>(s.stencil_rows)[0];
  for (const char* name : {"leapfrog", "rk4", "implicit_euler_newton"}) {
    const State end = run(name, s, start, 0.01, 2.0);
    EXPECT_NEAR(row.angle(end.q.data()), 40.0, 1e-10) << name;
    EXPECT_NEAR(angular_velocity(s.bodies[0], end)[2], 20.0, 1e-8) << name;
  }
}

TEST(Motor, IsFollowedInRateAndAngleByMethodsOfHighOrder) {
  const auto [s, start] = motor(shaken());
  for (const char* name : {"leapfrog", "rk4"}) {
    const State end = run(name, s, start, 0.001, 1.0);
    EXPECT_NEAR(angular_velocity(s.bodies[0], end)[2], shaken().rate(1.0), 1e-10) << name;
    const TurnRow& row = std::get<std::vector<TurnRow>>(s.stencil_rows)[0];
    EXPECT_NEAR(row.angle(end.q.data()), shaken().value(1.0), 1e-11) << name;
  }
}

TEST(Damper, AloneSlowsAParticleExponentially) {
  SystemBuilder builder;
  const Anchor wall = builder.add_world_point(Vector3d::Zero()),
               body = builder.add_particle(2.0, {1.0, 0.0, 0.0}, {0.3, 0.0, 0.0});
  builder.add_distance(wall, body, {.damping = 4.0}, 1.0);
  const auto [s, start] = builder.build();
  EXPECT_EQ(s.active_rows, 1);
  for (const IntegratorInfo& method : integrator_list()) {
    const State end = run(method.name, s, start, 1e-4, 1.0);
    EXPECT_NEAR(end.v[3], 0.3 * std::exp(-2.0), 1e-5) << method.name;
  }
}

}  // namespace
}  // namespace feder
