// Contacts in the implicit step: what they keep, and that both ways through the matrix agree.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "engine/body.h"
#include "engine/energy.h"
#include "solvers/simulate.h"
#include "tests/support/random.h"

namespace feder {
namespace {

// A net of springs above a ball, particles as small balls.
SystemBuilder::Built net_on_ball(int n, double friction) {
  SystemBuilder builder;
  builder.set_gravity({0.0, -9.81, 0.0});
  const double h = 1.0 / (n - 1);
  std::vector<Anchor> at;
  for (int i = 0; i < n * n; ++i)
    at.push_back(builder.add_particle(
        1.0 / (n * n), {h * (i / n) - 0.47, 0.312 + 1e-3 * std::sin(3.0 * i), h * (i % n) - 0.51}));
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      if (i + 1 < n) builder.add_distance(at[i * n + j], at[(i + 1) * n + j], {.stiffness = 1e3});
      if (j + 1 < n) builder.add_distance(at[i * n + j], at[i * n + j + 1], {.stiffness = 1e3});
      if (i + 1 < n && j + 1 < n)
        builder.add_distance(at[i * n + j], at[(i + 1) * n + j + 1], {.stiffness = 500.0});
    }
  builder.add_collider(builder.add_world_point({0, 0, 0}), SphereShape{0.3}, {friction, 0.0});
  for (const Anchor& a : at) builder.add_collider(a, SphereShape{0.01}, {friction, 0.0}, 1);
  return builder.build();
}

struct Motion {
  State state;
  RunResult result;
  ContactCounts counts;
  std::vector<EnergyLedger> ledgers;
};

Motion move(const System& system, const State& start, double dt, double end,
            const std::string& route = "auto") {
  Motion out{start, {}, {}, {}};
  Integrator integrator = make_integrator("implicit_euler_notes", system, {.route = route});
  History history;
  out.result =
      simulate(system, integrator, out.state, history, {.dt = dt, .end_time = end, .ledgers = &out.ledgers});
  out.counts = std::get<ImplicitEulerNotes>(integrator).contacts()->counts();
  return out;
}

TEST(ContactStep, ParticlesInTheMatrixMoveAsThroughDelassus) {
  for (const double friction : {0.0, 0.3}) {
    SCOPED_TRACE(friction);
    auto [system, state] = net_on_ball(7, friction);
    System plain = system;  // all contacts through W
    plain.contact_stencil.assign(plain.colliders.size(), -1);
    const Motion held = move(system, state, 2e-3, 0.12), free = move(plain, state, 2e-3, 0.12);
    ASSERT_TRUE(held.result.status.ok()) << held.result.status.reason;
    ASSERT_TRUE(free.result.status.ok()) << free.result.status.reason;
    EXPECT_GT(held.counts.passes, 0);
    EXPECT_EQ(free.counts.passes, 0);
    EXPECT_GT(held.counts.contacts, 60);
    EXPECT_LT((held.state.q - free.state.q).lpNorm<Eigen::Infinity>(), 2e-5);
  }
}

TEST(ContactStep, NothingSinksIntoTheBall) {
  const auto [system, state] = net_on_ball(9, 0.2);
  const Motion out = move(system, state, 2e-3, 0.2);
  ASSERT_TRUE(out.result.status.ok()) << out.result.status.reason;
  double deepest = 0.0, touching = 0.0;
  for (int i = 0; i < 81; ++i) {
    const double gap = out.state.q.segment<3>(3 * i).norm() - 0.31;
    deepest = std::max(deepest, -gap);
    touching += std::abs(gap) < 1e-6;
  }
  EXPECT_LT(deepest, 1e-9);
  EXPECT_GT(touching, 0);
}

TEST(ContactStep, LedgerCloses) {
  const auto [system, state] = net_on_ball(7, 0.3);
  const Motion out = move(system, state, 2e-3, 0.12);
  ASSERT_TRUE(out.result.status.ok());
  double worst = 0.0, friction = 0.0;
  for (const EnergyLedger& ledger : out.ledgers) {
    worst = std::max(worst, std::abs(ledger.imbalance()) / ledger.magnitude());
    friction += ledger.contact_work;
  }
  EXPECT_LT(friction, -1e-6);
  EXPECT_LT(worst, 1e-9);
}

// Boxes, balls and capsules thrown at a floor and at each other.
SystemBuilder::Built thrown(std::uint64_t seed, double friction, double restitution) {
  Random random(seed);
  SystemBuilder builder;
  builder.set_gravity({0.0, 0.0, -9.81});
  builder.add_collider(builder.add_world_point({0, 0, 0}), HalfSpaceShape{}, {friction, restitution});
  for (int i = 0; i < 3; ++i) {
    const int kind = random.below(3);
    const MassProperties mass = kind == 0   ? solid_sphere("ball", 1.0, 0.2)
                                : kind == 1 ? solid_box("box", 1.0, {0.3, 0.4, 0.5})
                                            : solid_cylinder("capsule", 1.0, 0.15, 0.5);
    const Shape shapes[3] = {SphereShape{0.2}, BoxShape{{0.15, 0.2, 0.25}}, CapsuleShape{0.15, 0.2}};
    const Anchor body = builder.add_body(
        mass, {.position = Vector3d(0.3 * random.uniform(), 0.3 * random.uniform(), 0.4 + 0.75 * i),
               .orientation =
                   Eigen::Quaterniond(random.uniform(), random.uniform(), random.uniform(), random.uniform())
                       .normalized()
                       .toRotationMatrix(),
               .velocity = random.vector(2.0),
               .angular_velocity = random.vector(5.0)});
    builder.add_collider(body, shapes[kind], {friction, restitution});
  }
  return builder.build();
}

TEST(ContactStep, EnergyOfThrownBodiesNeverRisesWithoutRestitution) {
  long contacts = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    const auto [system, start] = thrown(seed, 0.2 * static_cast<double>(seed % 4), 0.0);
    Integrator integrator = make_integrator("implicit_euler_notes", system);
    State state = start;
    History history;
    double energy = total_energy(system, state), rise = 0.0;
    const RunResult result =
        simulate(system, integrator, state, history,
                 {.dt = 2e-3, .end_time = 0.6, .observer = [&](const State& at, const History&) {
                    const double now = total_energy(system, at);
                    rise = std::max(rise, now - energy);
                    energy = now;
                    return true;
                  }});
    ASSERT_TRUE(result.status.ok()) << result.status.reason;
    // places are pushed out of what the linearised rows left: that may lift a body a little
    EXPECT_LT(rise, 2e-3 * 9.81);
    contacts += std::get<ImplicitEulerNotes>(integrator).contacts()->counts().contacts;
  }
  EXPECT_GT(contacts, 4000);
}

TEST(ContactStep, ABallReboundsWithItsRestitution) {
  for (const double restitution : {0.0, 0.5, 1.0}) {
    SystemBuilder builder;
    builder.add_collider(builder.add_world_point({0, 0, 0}), HalfSpaceShape{}, {0.0, restitution});
    builder.add_collider(builder.add_body(solid_sphere("ball", 2.0, 0.1),
                                          {.position = {0, 0, 0.15}, .velocity = {0, 0, -3.0}}),
                         SphereShape{0.1});
    const auto [system, state] = builder.build();
    const Motion out = move(system, state, 1e-3, 0.1);
    ASSERT_TRUE(out.result.status.ok());
    EXPECT_NEAR(out.state.v[3 * system.bodies[0].centre + 2], 3.0 * restitution, 1e-12);
  }
}

}  // namespace
}  // namespace feder
