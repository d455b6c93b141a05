// Impacts of several contacts at once, and impacts located between steps.
#include "solvers/contact/impacts.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "engine/body.h"
#include "engine/energy.h"
#include "solvers/simulate_impacts.h"
#include "tests/support/campaign.h"
#include "tests/support/random.h"

namespace feder {
namespace {

ImpactOutcome resolve(const System& system, State& state, const ContactRows& rows,
                      ImpactRule rule = ImpactRule::kStronge) {
  ImpactResponse response(system);
  EXPECT_TRUE(response.at(state.q).ok());
  return resolve_impacts(
      rows, [&](const VectorXd& force, VectorXd& v) { response(force, v); }, rule, state.v);
}

ContactRows contacts_of(const System& system, const State& state) {
  ContactFinder finder(system);
  ContactRows rows;
  finder.find(state, 0.0, rows);
  return rows;
}

// Balls of 1 kg in touch on a line, without gravity.
SystemBuilder::Built row_of_balls(const std::vector<double>& velocities, double restitution) {
  SystemBuilder builder;
  for (std::size_t i = 0; i < velocities.size(); ++i) {
    const Anchor ball = builder.add_body(
        solid_sphere("ball", 1.0, 0.5),
        {.position = Vector3d(1.0 * static_cast<double>(i), 0, 0), .velocity = {velocities[i], 0, 0}});
    builder.add_collider(ball, SphereShape{0.5}, {0.0, restitution});
  }
  return builder.build();
}

TEST(Impacts, CradlePassesTheVelocityOn) {
  for (const int moving : {1, 2}) {
    std::vector<double> velocities(5, 0.0);
    for (int i = 0; i < moving; ++i) velocities[static_cast<std::size_t>(i)] = 2.0;
    auto [system, state] = row_of_balls(velocities, 1.0);
    const ImpactOutcome out = resolve(system, state, contacts_of(system, state));
    ASSERT_TRUE(out.status.ok());
    for (int i = 0; i < 5; ++i)
      EXPECT_NEAR(state.v[3 * system.bodies[i].centre], i >= 5 - moving ? 2.0 : 0.0, 1e-12) << "ball " << i;
    EXPECT_NEAR(out.energy_change, 0.0, 1e-12);
  }
}

TEST(Impacts, PlasticRowMovesTogether) {
  auto [system, state] = row_of_balls({4.0, 0.0, 0.0, 0.0}, 0.0);
  ASSERT_TRUE(resolve(system, state, contacts_of(system, state)).status.ok());
  for (const Body& b : system.bodies) EXPECT_NEAR(state.v[3 * b.centre], 1.0, 1e-9);
}

// A rod on a ball joint struck by a ball at distance a from it: the rod turns with inertia m l^2/3 about the
// joint, so W_nn = 1/m_ball + a^2/(m l^2/3).
TEST(Impacts, HardRowsTakePart) {
  SystemBuilder builder;
  const double mass = 3.0, length = 1.0, arm = 0.7, edge = 1e-2;
  const Anchor rod =
      builder.add_body(solid_box("rod", mass, {edge, edge, length}), {.position = {0, 0, -0.5 * length}});
  builder.add(BallRow{{builder.add_world_point({0, 0, 0}), builder.anchor_at(rod, {0, 0, 0}), kRigid}});
  builder.add_collider(rod, BoxShape{{0.5 * edge, 0.5 * edge, 0.5 * length}}, {0.0, 1.0});
  const Anchor ball = builder.add_body(solid_sphere("ball", 1.0, 0.1),
                                       {.position = {-0.1 - 0.5 * edge, 0, -arm}, .velocity = {2, 0, 0}});
  builder.add_collider(ball, SphereShape{0.1}, {0.0, 1.0});
  auto [system, state] = builder.build();
  const ContactRows rows = contacts_of(system, state);
  ASSERT_EQ(rows.count(), 1);
  const ImpactOutcome out = resolve(system, state, rows);
  ASSERT_TRUE(out.status.ok());
  const double inertia = mass * (length * length + edge * edge) / 12.0 + mass * length * length / 4.0;
  const double p = 2.0 * 2.0 / (1.0 + arm * arm / inertia);
  EXPECT_NEAR(out.impulse[0], p, 1e-9);
  EXPECT_NEAR(state.v[3 * system.bodies[1].centre], 2.0 - p, 1e-9);
  EXPECT_NEAR(angular_velocity(system.bodies[0], state).y(), -p * arm / inertia, 1e-9);
}

// Boxes and balls that touch a floor and each other at random velocities.
SystemBuilder::Built pile(Random& random, double restitution) {
  SystemBuilder builder;
  const double friction = random.uniform(0.0, 1.2);
  builder.add_collider(builder.add_world_point({0, 0, 0}), HalfSpaceShape{}, {friction, restitution});
  const int count = 1 + random.below(4);
  double height = 0.0;
  for (int i = 0; i < count; ++i) {
    const Vector3d half{random.uniform(0.1, 0.5), random.uniform(0.1, 0.5), random.uniform(0.1, 0.5)};
    const bool ball = random.below(3) == 0;
    const double up = ball ? half.x() : half.z();
    const Anchor body =
        builder.add_body(ball ? solid_sphere("ball", random.uniform(0.1, 10.0), half.x())
                              : solid_box("box", random.uniform(0.1, 10.0), 2.0 * half),
                         {.position = {0.05 * random.uniform(), 0.05 * random.uniform(), height + up},
                          .velocity = random.vector(3.0),
                          .angular_velocity = random.vector(5.0)});
    builder.add_collider(body, ball ? Shape(SphereShape{half.x()}) : Shape(BoxShape{half}),
                         {friction, restitution});
    height += 2.0 * up;
  }
  return builder.build();
}

// Traps class 21: energy never rises, impulses in their cones, momentum kept, nothing approaches any more.
TEST(ImpactsCampaign, RandomPilesKeepTheLaws) {
  const int cases = test::campaign_cases(20'000);
  double rise = -1.0, outside = -1.0, momentum = 0.0, approach = 0.0;
  int several = 0, unsolved = 0;
  for (int i = 0; i < cases; ++i) {
    SCOPED_TRACE(i);
    Random random(static_cast<std::uint64_t>(i));
    auto [system, state] = pile(random, 0.25 * (i % 5));
    const ContactRows rows = contacts_of(system, state);
    ASSERT_GT(rows.count(), 0);
    const State before = state;
    const ImpactOutcome out = resolve(system, state, rows);
    if (!out.status.ok()) {
      ++unsolved;
      continue;
    }
    ASSERT_TRUE(state.v.allFinite());
    several += out.rounds > 1;
    const double energy = kinetic_energy(system, before);
    rise = std::max(rise, kinetic_energy_change(system, before.v, state.v) / energy);
    VectorXd u, push = VectorXd::Zero(state.v.size());
    rows.velocities(state.v, u);
    const double speed = before.v.lpNorm<Eigen::Infinity>();
    Vector3d from_floor = Vector3d::Zero();
    for (int k = 0; k < rows.count(); ++k) {
      const Vector3d y = out.impulse.segment<3>(3 * k);
      approach = std::max(approach, -u[3 * k] / speed);
      outside = std::max(outside, (y.tail<2>().norm() - rows.contacts[k].surface.friction * y[0]) /
                                      (1e-300 + out.impulse.norm()));
      if (system.colliders[rows.contacts[k].a].fixed) from_floor += rows.contacts[k].frame.transpose() * y;
    }
    const Vector3d change = linear_momentum(system, state) - linear_momentum(system, before) - from_floor;
    momentum = std::max(momentum, change.norm() / (1.0 + from_floor.norm()));
  }
  std::printf(
      "%d piles: %d unsolved, %d with several rounds; energy rises by %.1e at most, outside the cone %.1e, "
      "momentum %.1e, approach left %.1e\n",
      cases, unsolved, several, rise, outside, momentum, approach);
  EXPECT_LE(unsolved, cases / 1000);
  EXPECT_LE(rise, 1e-12);
  EXPECT_LE(outside, 1e-12);
  EXPECT_LE(momentum, 1e-12);
  EXPECT_LE(approach, 3e-9);  // measured 1.1e-9: what counts as rest is 1e-9 of the fastest approach
  EXPECT_GT(several, cases / 10);
}

SystemBuilder::Built bouncing_ball(double height, double restitution) {
  SystemBuilder builder;
  builder.set_gravity({0.0, 0.0, -9.81});
  builder.add_collider(builder.add_world_point({0, 0, 0}), HalfSpaceShape{}, {0.0, restitution});
  builder.add_collider(builder.add_body(solid_sphere("ball", 1.0, 0.1), {.position = {0, 0, 0.1 + height}}),
                       SphereShape{0.1});
  return builder.build();
}

TEST(SimulateImpacts, BouncesComeAtTheirTimes) {
  const double height = 1.0, e = 0.7, g = 9.81, fall = std::sqrt(2.0 * height / g);
  for (const char* name : {"leapfrog", "rk4"}) {
    SCOPED_TRACE(name);
    auto [system, state] = bouncing_ball(height, e);
    History history;
    const ImpactRun run = simulate_impacts(system, name, {}, state, history, {.dt = 0.03, .end_time = 2.0});
    ASSERT_TRUE(run.status.ok()) << run.status.reason;
    ASSERT_EQ(run.impacts, 4);
    double t = fall, flight = 2.0 * fall * e;
    for (const Impact& impact : run.record) {
      EXPECT_NEAR(impact.t, t, 1e-10);
      t += flight, flight *= e;
    }
    EXPECT_EQ(state.t, 2.0);
  }
}

TEST(SimulateImpacts, BouncesThatDieOutEndTheRunByName) {
  auto [system, state] = bouncing_ball(0.5, 0.5);
  History history;
  const ImpactRun run = simulate_impacts(system, "rk4", {}, state, history, {.dt = 0.01, .end_time = 5.0});
  EXPECT_EQ(run.status.code, StatusCode::kLimitReached);
  EXPECT_NE(run.status.reason.find("stay closed"), std::string::npos) << run.status.reason;
  EXPECT_LT(run.impacts, 60);
  EXPECT_NEAR(state.t, std::sqrt(2.0 * 0.5 / 9.81) * (1.0 + 2.0 * 0.5 / (1.0 - 0.5)), 0.02);
}

// A mass on a spring that strikes a wall: the order of the integrator survives the impact.
double error_after_impact(const char* name, double dt) {
  SystemBuilder builder;
  const Anchor wall = builder.add_world_point({0, 0, 0}), hook = builder.add_world_point({2.0, 0, 0});
  const double mass = 1.3, stiffness = 50.0, omega = std::sqrt(stiffness / mass);
  const Anchor ball = builder.add_particle(mass, {0.6, 0, 0}, {0, 0, 0});
  builder.add_distance(hook, ball, {.stiffness = stiffness}, 1.5);  // at rest at x = 0.5
  Matrix3d to_x;
  to_x << 0, 0, 1, 0, 1, 0, -1, 0, 0;  // normal +x
  builder.add_collider(wall, HalfSpaceShape{}, {0.0, 1.0}, 0, to_x);
  builder.add_collider(ball, SphereShape{0.45});
  auto [system, state] = builder.build();
  History history;
  const ImpactRun run = simulate_impacts(system, name, {}, state, history, {.dt = dt, .end_time = 1.0});
  EXPECT_TRUE(run.status.ok()) << run.status.reason;
  EXPECT_GE(run.impacts, 1);
  // x = 0.5 + 0.1 cos(w t) until 0.45, then time runs backwards: period 2 arccos(-1/2)/w
  const double period = 2.0 * std::acos(-0.5) / omega;
  const double t = std::remainder(1.0, period);
  return std::abs(state.q[3 * 2] - (0.5 + 0.1 * std::cos(omega * t)));
}

TEST(SimulateImpacts, OrderSurvivesImpacts) {
  const double leapfrog = error_after_impact("leapfrog", 5e-3) / error_after_impact("leapfrog", 2.5e-3);
  EXPECT_NEAR(std::log2(leapfrog), 2.0, 0.35);
  const double rk4 = error_after_impact("rk4", 2e-2) / error_after_impact("rk4", 1e-2);
  EXPECT_NEAR(std::log2(rk4), 4.0, 0.6);
}

}  // namespace
}  // namespace feder
