// What every integrator of the list promises, generated from the list; then claims between methods.
#include <gtest/gtest.h>

#include <cmath>

#include "models/catalog.h"
#include "solvers/simulate.h"
#include "tests/solvers/random_system.h"

namespace feder {
namespace {

template <class List>
struct AsTypes;
template <class... T>
struct AsTypes<std::variant<T...>> {
  using type = ::testing::Types<T...>;
};
struct Names {
  template <class T>
  static std::string GetName(int) {
    return T::kInfo.name;
  }
};

template <class T>
class EveryIntegrator : public ::testing::Test {
 protected:
  static State run(const System& system, State state, double dt, double end,
                   std::vector<EnergyLedger>* ledgers = nullptr) {
    Integrator integrator = T(system, {});
    History history;
    const RunResult result =
        simulate(system, integrator, state, history, {.dt = dt, .end_time = end, .ledgers = ledgers});
    EXPECT_TRUE(result.status.ok()) << result.status.reason;
    return state;
  }
};
TYPED_TEST_SUITE(EveryIntegrator, AsTypes<Integrator>::type, Names);

// Least-squares slope of log error over log dt.
double fitted_order(const std::vector<double>& dt, const std::vector<double>& error) {
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  const double n = static_cast<double>(dt.size());
  for (std::size_t i = 0; i < dt.size(); ++i) {
    const double x = std::log(dt[i]), y = std::log(error[i]);
    sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

template <class T>
double measured_order(const System& system, const State& start, double end, const State& exact,
                      double coarsest) {
  std::vector<double> steps, errors;
  for (double dt = coarsest; steps.size() < 4; dt *= 0.5) {
    Integrator integrator = T(system, {});
    State state = start;
    History history;
    EXPECT_TRUE(simulate(system, integrator, state, history, {.dt = dt, .end_time = end}).status.ok());
    steps.push_back(dt);
    // position and velocity: one of them alone may have a zero of its error near the end time
    errors.push_back(std::hypot((state.q - exact.q).norm(), 0.1 * (state.v - exact.v).norm()));
  }
  return fitted_order(steps, errors);
}

TYPED_TEST(EveryIntegrator, HasItsDeclaredOrderOnTheDampedOscillatorFromBothSides) {
  const Model model = make_model("damped_oscillator");
  const double end = 0.5 * model.end_time, coarsest = end / (TypeParam::kInfo.order == 1   ? 4000.0
                                                             : TypeParam::kInfo.order == 2 ? 400.0
                                                                                           : 100.0);
  const double order = measured_order<TypeParam>(model.system, model.state, end, model.exact(end), coarsest);
  EXPECT_NEAR(order, TypeParam::kInfo.order, 0.05);
}

TYPED_TEST(EveryIntegrator, HasItsDeclaredOrderOnANetWithEveryRowType) {
  const auto [system, start] =
      test::random_system(11, {.particles = 8, .stiffness = 50.0, .damping_time = 0.01});
  Integrator reference = make_integrator("rk4", system);
  State exact = start;
  History history;
  const double end = 0.1;
  ASSERT_TRUE(simulate(system, reference, exact, history, {.dt = 1e-5, .end_time = end}).status.ok());
  const double coarsest = TypeParam::kInfo.order == 1 ? 2e-4 : 5e-4;
  EXPECT_NEAR(measured_order<TypeParam>(system, start, end, exact, coarsest), TypeParam::kInfo.order, 0.1);
}

TYPED_TEST(EveryIntegrator, ClosesItsEnergyLedger) {
  const auto [system, start] =
      test::random_system(7, {.particles = 12, .stiffness = 1e3, .damping_time = 0.01});
  std::vector<EnergyLedger> ledgers;
  (void)this->run(system, start, 1e-4, 0.02, &ledgers);
  ASSERT_EQ(ledgers.size(), 200u);
  double worst = 0.0;
  for (const EnergyLedger& ledger : ledgers) {
    ASSERT_GT(ledger.magnitude(), 1e-6);
    worst = std::max(worst, std::abs(ledger.imbalance()) / ledger.magnitude());
  }
  EXPECT_LT(worst, 1e-12);  // measured below 3e-13
}

TYPED_TEST(EveryIntegrator, ClosesItsEnergyLedgerWithRods) {
  const auto [system, start] =
      test::random_system(7, {.particles = 12, .stiffness = 1e3, .damping_time = 0.01, .rods = 5});
  ASSERT_TRUE(system.has_hard_rows);
  if (TypeParam::refusal(system).empty()) {
    std::vector<EnergyLedger> ledgers;
    (void)this->run(system, start, 1e-3, 0.1, &ledgers);
    double worst = 0.0;
    for (const EnergyLedger& ledger : ledgers)
      worst = std::max(worst, std::abs(ledger.imbalance()) / ledger.magnitude());
    EXPECT_LT(worst, 1e-12);
  } else {
    EXPECT_NE(TypeParam::refusal(system).find("is rigid"), std::string::npos);
  }
}

TYPED_TEST(EveryIntegrator, KeepsLinearMomentumOfAFreeNet) {
  SystemBuilder builder;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<Anchor> nodes;
  for (int i = 0; i < 10; ++i)
    nodes.push_back(builder.add_particle(0.5 + std::abs(unit(random)),
                                         {unit(random), unit(random), unit(random)},
                                         {unit(random), unit(random), 1.0}));
  for (int i = 1; i < 10; ++i) builder.add_distance(nodes[i - 1], nodes[i], {100.0, 0.01}, 0.7);
  builder.add(CurvatureRow{{nodes[0].node, nodes[1].node, nodes[2].node}, 5.0, 0.01});
  const auto [system, start] = builder.build();
  const Vector3d before = linear_momentum(system, start);
  ASSERT_GT(before.norm(), 1.0);
  const Vector3d after = linear_momentum(system, this->run(system, start, 1e-4, 1.0));
  EXPECT_LT((after - before).norm() / before.norm(), 1e-12);  // 1e4 steps
}

TYPED_TEST(EveryIntegrator, LandsOnTheEndTimeExactly) {
  const Model model = make_model("oscillator");
  for (double end : {0.1, 0.3, 1.0 / 3.0})
    for (double dt : {0.01, 0.007, end})
      EXPECT_EQ(this->run(model.system, model.state, std::min(dt, end), end).t, end);
}

TYPED_TEST(EveryIntegrator, LeavesTheStateUntouchedWhenAStepFails) {
  auto [system, start] = test::random_system(9, {.particles = 10});
  start.q[3 * 4] = std::numeric_limits<double>::quiet_NaN();
  Integrator integrator = TypeParam(system, {});
  State state = start;
  History history;
  const RunResult result = simulate(system, integrator, state, history, {.dt = 1e-3, .end_time = 0.1});
  EXPECT_EQ(result.status.code, StatusCode::kNonFinite) << result.status.reason;
  EXPECT_FALSE(result.status.reason.empty());
  EXPECT_EQ(result.steps, 0);
  EXPECT_EQ(state.v, start.v);
  EXPECT_EQ(state.t, 0.0);
}

TYPED_TEST(EveryIntegrator, ResumesBitwise) {
  const auto [system, start] = test::random_system(13, {.particles = 10, .stiffness = 100.0});
  const State whole = this->run(system, start, 1e-3, 0.2);
  Integrator first = TypeParam(system, {});
  State state = start;
  History history;
  ASSERT_TRUE(simulate(system, first, state, history, {.dt = 1e-3, .end_time = 0.1}).status.ok());
  Integrator second = TypeParam(system, {});
  for (int k = 0; k < 100; ++k)
    ASSERT_TRUE(std::visit(
        [&](auto& i) {
          if (k == 0 && !i.prepare().ok()) return false;
          return i.step(1e-3, state, history, nullptr).ok();
        },
        second));
  EXPECT_EQ(state.q, whole.q);
  EXPECT_EQ(state.v, whole.v);
}

TYPED_TEST(EveryIntegrator, NeverMovesAPinnedParticle) {
  const Model model = make_model("S2(6)");
  const State end = this->run(model.system, model.state, 1e-5, 0.01);
  ASSERT_GT((end.q - model.state.q).norm(), 1e-6);
  for (int i : model.system.masked) EXPECT_EQ(end.q[i], model.state.q[i]);
}

TYPED_TEST(EveryIntegrator, ReportsANonFiniteUserForce) {
  SystemBuilder builder;
  const Anchor a = builder.add_world_point({0, 0, 0}), b = builder.add_particle(1.0, {1, 0, 0});
  builder.add_distance(a, b, {10.0, 0.0});
  UserForce force;
  force.force = [](double t, const VectorXd&, const VectorXd&, VectorXd& f) {
    f[3] += t > 0.5 ? std::nan("") : 0.1;
  };
  builder.set_user_force(force);
  auto [system, state] = builder.build();
  Integrator integrator = TypeParam(system, {});
  History history;
  const RunResult result = simulate(system, integrator, state, history, {.dt = 0.01, .end_time = 1.0});
  EXPECT_EQ(result.status.code, StatusCode::kNonFinite) << to_string(result.status.code);
  EXPECT_LE(result.steps, 60);
}

TEST(ExplicitEuler, GainsEnergyByExactlyOnePlusOmegaDtSquaredPerStep) {
  const Model model = make_model("oscillator");
  const System& s = model.system;
  const double omega2 = s.distance.spring[0] * s.inverse_mass.maxCoeff(), dt = 0.01 / std::sqrt(omega2);
  Integrator integrator = make_integrator("explicit_euler", s);
  State state = model.state;
  History history;
  for (int k = 0; k < 50; ++k) {
    const double before = total_energy(s, state);
    ASSERT_TRUE(std::visit([&](auto& i) { return i.step(dt, state, history, nullptr); }, integrator).ok());
    EXPECT_NEAR(total_energy(s, state) / before, 1.0 + omega2 * dt * dt, 1e-12);
  }
}

TEST(ImplicitEuler, AmplifiesTheOscillatorByOneOverRootOnePlusOmegaDtSquared) {
  const Model model = make_model("oscillator");
  const double omega = std::sqrt(model.system.distance.spring[0] * model.system.inverse_mass.maxCoeff());
  for (const char* name : {"implicit_euler_notes", "implicit_euler_geometric", "implicit_euler_newton"})
    for (double omega_dt : {0.1, 1.0, 10.0, 1000.0}) {
      Integrator integrator = make_integrator(name, model.system);
      State state = model.state;
      History history;
      const double before = total_energy(model.system, state), dt = omega_dt / omega;
      ASSERT_TRUE(simulate(model.system, integrator, state, history, {.dt = dt, .end_time = dt}).status.ok());
      EXPECT_NEAR(std::sqrt(total_energy(model.system, state) / before),
                  1.0 / std::sqrt(1.0 + omega_dt * omega_dt), 1e-9)
          << name;
    }
}

TEST(Leapfrog, IsTimeReversible) {
  Model model = make_model("spring_pendulum");
  const State start = model.state;
  State state = start;
  Integrator forward = make_integrator("leapfrog", model.system);
  History history;
  const double dt = model.end_time / 5000.0;
  ASSERT_TRUE(
      simulate(model.system, forward, state, history, {.dt = dt, .end_time = model.end_time}).status.ok());
  ASSERT_GT((state.q - start.q).norm(), 0.01);
  state.v = -state.v, state.t = 0.0;
  History back;
  ASSERT_TRUE(
      simulate(model.system, forward, state, back, {.dt = dt, .end_time = model.end_time}).status.ok());
  EXPECT_LT((state.q - start.q).norm() / start.q.norm(), 1e-10);
}

TEST(Leapfrog, KeepsAngularMomentumOfAFreeNet) {
  SystemBuilder builder;
  std::vector<Anchor> nodes;
  for (int i = 0; i < 8; ++i)
    nodes.push_back(builder.add_particle(0.2 + 0.1 * i, {std::cos(1.3 * i), std::sin(2.1 * i), 0.3 * i},
                                         {0.1 * i, -0.2, std::sin(3.0 * i)}));
  for (int i = 1; i < 8; ++i) builder.add_distance(nodes[i - 1], nodes[i], {200.0, 0.0}, 0.8);
  const auto [system, start] = builder.build();
  for (const char* name : {"leapfrog", "implicit_euler_notes"}) {
    Integrator integrator = make_integrator(name, system);
    State state = start;
    History history;
    ASSERT_TRUE(simulate(system, integrator, state, history, {.dt = 1e-3, .end_time = 10.0}).status.ok());
    const Vector3d before = angular_momentum(system, start);
    ASSERT_GT(before.norm(), 0.1);
    EXPECT_LT((angular_momentum(system, state) - before).norm() / before.norm(), 1e-12) << name;  // 1e4 steps
  }
}

TEST(ImplicitEulerNewton, LosesAngularMomentumUnlikeTheNotesStep) {
  SystemBuilder builder;
  const Anchor a = builder.add_particle(1.0, {-1, 0, 0}, {0, -1, 0}),
               b = builder.add_particle(1.0, {1, 0, 0}, {0, 1, 0});
  builder.add_distance(a, b, {100.0, 0.0});
  const auto [system, start] = builder.build();
  Integrator integrator = make_integrator("implicit_euler_newton", system);
  State state = start;
  History history;
  ASSERT_TRUE(simulate(system, integrator, state, history, {.dt = 0.01, .end_time = 10.0}).status.ok());
  EXPECT_LT(angular_momentum(system, state).norm(), 0.99 * angular_momentum(system, start).norm());
}

// A rod swinging from the horizontal: Newton keeps its length, one linearisation misses it by dt^2 v_perp^2 /
// (2 l).
TEST(ImplicitEulerNewton, HoldsRodsWhereTheLinearStepMissesThemByItsSecondOrderTerm) {
  const double dt = 1e-3;
  Model model = make_model("S1h(1)");
  const System& s = model.system;
  VectorXd phi;
  {
    Integrator newton = make_integrator("implicit_euler_newton", s);
    State state = model.state;
    History history;
    double worst = 0.0;
    ASSERT_TRUE(simulate(s, newton, state, history,
                         {.dt = dt,
                          .end_time = 0.1,
                          .observer =
                              [&](const State& at, const History&) {
                                evaluate_phi(s, at.q, phi);
                                worst = std::max(worst, phi.cwiseAbs().maxCoeff());
                                return true;
                              }})
                    .status.ok());
    EXPECT_LT(worst, 1e-9);  // measured below 1e-15
  }
  Integrator linear = make_integrator("implicit_euler_notes", s);
  State state = model.state;
  History history;
  // settle, then look at one step: phi' = phi + dt J v' + dt^2 |v_perp|^2 / (2 l)
  int looked = 0;
  ASSERT_TRUE(simulate(s, linear, state, history,
                       {.dt = dt,
                        .end_time = 0.03,
                        .observer =
                            [&](const State& at, const History&) {
                              if (at.t < 0.01) return true;
                              const Vector3d x = at.q.tail<3>() - at.q.head<3>(), v = at.v.tail<3>();
                              const double l = x.norm(), across = (v - x * x.dot(v) / (l * l)).squaredNorm();
                              evaluate_phi(s, at.q, phi);
                              EXPECT_NEAR(phi.sum() / (dt * dt * across / (2.0 * l)), 1.0, 0.05);
                              ++looked;
                              return true;
                            }})
                  .status.ok());
  EXPECT_GT(looked, 15);
}

TEST(ImplicitEulerNewton, ConvergesOnTheHangingChainWithStiffSpringsAtAFrameStep) {
  Model model = make_model("S1(100)");
  Integrator newton = make_integrator("implicit_euler_newton", model.system);
  History history;
  const RunResult result =
      simulate(model.system, newton, model.state, history, {.dt = 1.0 / 60.0, .end_time = 0.25});
  ASSERT_TRUE(result.status.ok()) << result.status.reason;
  VectorXd phi;
  evaluate_phi(model.system, model.state.q, phi);
  EXPECT_LT(phi.cwiseAbs().maxCoeff() / 0.01, 1e-2);  // strain
}

// Wrinkles: compressed springs make the full matrix indefinite, and some steps pass a saddle.
TEST(ImplicitEulerNewton, ConvergesOnBucklingClothAtAFrameStep) {
  Model model = make_model("S2(20)");
  ImplicitEulerNewton newton(model.system, {});
  ASSERT_TRUE(newton.prepare().ok());
  History history;
  for (int n = 0; n < 60; ++n) {
    const Status status = newton.step(1.0 / 60.0, model.state, history, nullptr);
    ASSERT_TRUE(status.ok()) << "step " << n << ": " << status.reason;
  }
  EXPECT_GT(newton.counts().indefinite_matrices, 10);                        // 41
  EXPECT_LT(newton.counts().newton_iterations, 25 * newton.counts().steps);  // 10 per step
}

TEST(TautString, StabilityLimitOfTheNotesStepIsSharp) {
  const Model model =
      make_model("taut_string:modes=-1:1e-9");  // the mode that goes first, tiny: tilted links stiffen
  // highest transverse frequency of 20 beads: the limit is 2 / omega
  const double tension = 10.0, mass = 0.01, link = 1.0 / 21.0;
  const double limit = 2.0 / (2.0 * std::sqrt(tension / (mass * link)) * std::sin(20.0 * M_PI / 42.0));
  auto amplitude = [&](const char* name, double ratio) {
    Integrator integrator = make_integrator(name, model.system);
    State state = model.state;
    History history;
    (void)simulate(model.system, integrator, state, history,
                   {.dt = ratio * limit, .end_time = 2000.0 * ratio * limit, .divergence = 1e12});
    double largest = 0.0;
    for (int i = 1; i < state.q.size(); i += 3) largest = std::max(largest, std::abs(state.q[i]));
    return largest;
  };
  EXPECT_LT(amplitude("implicit_euler_notes", 0.98), 2e-8);
  EXPECT_GT(amplitude("implicit_euler_notes", 1.02), 1e-5);  // measured 7e-4, where the tilt saturates it
  EXPECT_LT(amplitude("implicit_euler_geometric", 5.0), 1e-9);
}

TEST(Methods, RankAsTheTheorySays) {
  const Model model = make_model("spring_pendulum");
  Integrator judge = make_integrator("rk4", model.system);
  State exact = model.state;
  History history;
  const double end = 0.2 * model.end_time, dt = end / 2000.0;
  ASSERT_TRUE(simulate(model.system, judge, exact, history, {.dt = dt / 20.0, .end_time = end}).status.ok());
  auto error = [&](const char* name) {
    Integrator integrator = make_integrator(name, model.system);
    State state = model.state;
    History past;
    const RunResult run = simulate(model.system, integrator, state, past, {.dt = dt, .end_time = end});
    EXPECT_TRUE(run.status.ok()) << run.status.reason;
    return (state.q - exact.q).norm();
  };
  const double rk4 = error("rk4"), leapfrog = error("leapfrog"), euler = error("implicit_euler_newton");
  EXPECT_LT(rk4, 0.1 * leapfrog);
  EXPECT_LT(leapfrog, 0.1 * euler);
}

}  // namespace
}  // namespace feder
