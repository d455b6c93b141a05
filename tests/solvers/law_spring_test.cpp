// Springs with laws of their own.
#include "engine/law_spring.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "engine/check.h"
#include "solvers/simulate.h"
#include "tests/support/random.h"

namespace feder {
namespace {

/// Hardening: T = k x + c x^3, x = l - l0.
std::function<Tension(double, double)> hardening(double k, double c, double rest) {
  return [=](double length, double) {
    const double x = length - rest;
    return Tension{k * x + c * x * x * x, k + 3.0 * c * x * x, 0.0};
  };
}

State run(const char* name, const System& s, const State& start, double dt, double end,
          std::vector<EnergyLedger>* ledgers = nullptr) {
  Integrator integrator = make_integrator(name, s);
  State state = start;
  History history;
  const RunResult result =
      simulate(s, integrator, state, history, {.dt = dt, .end_time = end, .ledgers = ledgers});
  EXPECT_TRUE(result.status.ok()) << name << ": " << result.status.reason;
  return state;
}

TEST(LawSpring, WithALinearLawIsTheDistanceRow) {
  auto scene = [](bool law) {
    SystemBuilder builder;
    const Anchor wall = builder.add_world_point({0.0, 0.0, 0.0}),
                 mass = builder.add_particle(0.5, {0.3, 0.8, -0.2}, {1.0, 0.0, 0.5});
    if (law)
      builder.add_law_spring({{wall, mass}, [](double length, double rate) {
                                return Tension{40.0 * (length - 0.7) + 0.3 * rate, 40.0, 0.3};
                              }});
    else
      builder.add_distance(wall, mass, {40.0, 0.0, 0.3}, 0.7);
    builder.set_gravity({0.0, -9.81, 0.0});
    return builder.build();
  };
  const auto row = scene(false), law = scene(true);
  for (const char* name : {"explicit_euler", "rk4", "implicit_euler_newton"}) {
    const State a = run(name, row.system, row.state, 1e-3, 0.5),
                b = run(name, law.system, law.state, 1e-3, 0.5);
    // implicit Euler takes the rate of a row from its two lengths, of a law from the end's velocity
    EXPECT_LT((a.q - b.q).norm(), name == std::string("implicit_euler_newton") ? 1e-3 : 1e-11) << name;
  }
}

TEST(LawSpring, KeepsItsEnergyAndTheLedger) {
  SystemBuilder builder;
  const Anchor wall = builder.add_world_point({0.0, 0.0, 0.0}),
               body =
                   builder.add_body(solid_box("box", 1.0, {0.3, 0.2, 0.1}), {.position = {0.0, -0.6, 0.1}});
  builder.add_law_spring({{wall, {.body = body.body, .point = {0.15, 0.1, 0.05}}},
                          hardening(30.0, 500.0, 0.4),
                          [](double length) {
                            const double x = length - 0.4;
                            return 15.0 * x * x + 125.0 * x * x * x * x;
                          }});
  builder.set_gravity({0.0, -9.81, 0.0});
  const auto [s, start] = builder.build();
  std::vector<EnergyLedger> ledgers;
  const State end = run("rk4", s, start, 1e-3, 2.0, &ledgers);
  EXPECT_NEAR(total_energy(s, end), total_energy(s, start), 1e-6);
  for (const EnergyLedger& ledger : ledgers)
    EXPECT_LT(std::abs(ledger.imbalance()), 1e-12 * ledger.magnitude() + 1e-15);
}

TEST(LawSpring, StiffnessIsTheDerivativeOfItsForce) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Random random(seed);
    SystemBuilder builder;
    std::array<Anchor, 2> bodies;
    for (Anchor& body : bodies) {
      body = builder.add_body(solid_box("box", 1.0, {0.3, 0.2, 0.1}), {.position = random.vector()});
      body.point = random.vector(0.3);
    }
    builder.add_law_spring({{bodies[0], bodies[1]}, hardening(30.0, 50.0, 0.4)});
    const auto [s, state] = builder.build();
    const LawSpring& spring = s.law_springs[0];
    const VectorXd v = random.numbers(12);
    Eigen::MatrixXd K(12, 12);
    spring.stiffness(state.q.data(), v.data(), 1.0, 0.0, K);
    // nodes of the spring: centre and spin of a, then of b
    auto along = [&](double step) {
      VectorXd direction = VectorXd::Zero(12), q;
      for (int c = 0; c < 12; ++c) direction[3 * spring.nodes[c / 3] + c % 3] = v[c];
      advance(s, step, direction, state.q, q);
      const double x = spring.length(q.data()) - 0.4;
      return 15.0 * x * x + 12.5 * x * x * x * x;
    };
    constexpr double kStep = 1e-4;
    const double second = (along(kStep) - 2.0 * along(0.0) + along(-kStep)) / (kStep * kStep);
    EXPECT_NEAR(v.dot(K * v), second, 1e-5 * K.norm()) << seed;
  }
}

TEST(LawSpring, HoldsAStiffDashpotUnderNewton) {
  SystemBuilder builder;
  const Anchor wall = builder.add_world_point({0.0, 0.0, 0.0}),
               mass = builder.add_particle(1.0, {1.0, 0.0, 0.0}, {0.3, 0.0, 0.0});
  builder.add_law_spring(
      {{wall, mass}, [](double, double rate) {
         return Tension{1e6 * std::tanh(rate), 0.0, 1e6 / std::cosh(rate) / std::cosh(rate)};
       }});
  const auto [s, start] = builder.build();
  EXPECT_LT(std::abs(run("implicit_euler_newton", s, start, 0.01, 0.1).v[3]), 1e-10);
}

TEST(LawSpring, IsRefusedWithoutALawAndReportedWithoutALength) {
  SystemBuilder builder;
  const Anchor a = builder.add_particle(1.0, {0, 0, 0}), b = builder.add_particle(1.0, {0, 0, 0});
  try {
    builder.add_law_spring({{a, b}, {}});
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("law spring 0"), std::string::npos) << e.what();
  }
  builder.add_law_spring({{a, b}, hardening(1.0, 0.0, 1.0)});
  const auto [s, start] = builder.build();
  for (const IntegratorInfo& method : integrator_list()) {
    Integrator integrator = make_integrator(method.name, s);
    State state = start;
    History history;
    EXPECT_FALSE(simulate(s, integrator, state, history, {.dt = 0.01, .end_time = 0.1}).status.ok())
        << method.name;
  }
}

}  // namespace
}  // namespace feder
