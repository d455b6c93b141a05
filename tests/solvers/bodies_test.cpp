// Every integrator and route with rigid bodies.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "models/catalog.h"
#include "solvers/reference.h"
#include "solvers/simulate.h"
#include "solvers/stability.h"
#include "tests/solvers/random_system.h"
#include "tests/support/random.h"

namespace feder {
namespace {

MassProperties brick() {
  return solid_box("brick", 1.2, {0.5, 0.3, 0.1});
}

/// A free asymmetric top: the middle axis, so that it flips.
SystemBuilder::Built top(double speed) {
  SystemBuilder builder;
  builder.add_body(brick(), {.angular_velocity = speed * Vector3d(0.1, 1.0, 0.05).normalized()});
  return builder.build();
}

/// A brick hung on two springs, one end of each off its centre, and a particle: smooth, everything turns.
SystemBuilder::Built hung_brick(double stiffness = 40.0, double damping_time = 0.0) {
  SystemBuilder builder;
  const Anchor left = builder.add_world_point({-0.4, 0.6, 0.0}),
               right = builder.add_world_point({0.5, 0.7, 0.2}),
               mass = builder.add_particle(0.3, {0.4, -0.4, 0.1});
  const Anchor body = builder.add_body(brick(), {.angular_velocity = {1.0, 2.0, -1.5}});
  auto corner = [&](double x, double y, double z) { return Anchor{.body = body.body, .point = {x, y, z}}; };
  builder.add(AnchorDistanceRow{{left, corner(-0.25, 0.15, 0.05), stiffness, damping_time}, 0.4});
  builder.add(AnchorDistanceRow{{right, corner(0.25, 0.15, -0.05), stiffness, damping_time}, 0.5});
  builder.add(AnchorDistanceRow{{corner(0.25, -0.15, 0.05), mass, stiffness, damping_time}, 0.3});
  builder.set_gravity({0.0, -9.81, 0.0});
  return builder.build();
}

/// Bricks in a chain of ball joints from the ceiling, the last one with a hinge; all joints hard.
SystemBuilder::Built jointed_bricks(int count, double stiffness = INFINITY, double damping_time = 0.0) {
  SystemBuilder builder;
  const Anchor ceiling = builder.add_world_point({0.0, 0.0, 0.0});
  Anchor last = ceiling;
  for (int i = 0; i < count; ++i) {
    const Anchor body = builder.add_body(brick(), {.position = {0.25 + 0.5 * i, 0.0, 0.0}});
    const Anchor begin{.body = body.body, .point = {-0.25, 0.0, 0.0}};
    builder.add(BallRow{{last, begin, stiffness, damping_time}});
    if (i > 0 && i + 1 == count) {  // hinge about z
      builder.add(PerpendicularRow{{last, begin, stiffness, damping_time}, {0, 0, 1}, {1, 0, 0}});
      builder.add(PerpendicularRow{{last, begin, stiffness, damping_time}, {0, 0, 1}, {0, 1, 0}});
    }
    last = {.body = body.body, .point = {0.25, 0.0, 0.0}};
  }
  builder.set_gravity({0.0, -9.81, 3.0});
  return builder.build();
}

State run(const char* name, const System& system, const State& start, double dt, double end,
          std::vector<EnergyLedger>* ledgers = nullptr, const IntegratorOptions& options = {}) {
  Integrator integrator = make_integrator(name, system, options);
  State state = start;
  History history;
  const RunResult result =
      simulate(system, integrator, state, history, {.dt = dt, .end_time = end, .ledgers = ledgers});
  EXPECT_TRUE(result.status.ok()) << name << ": " << result.status.reason;
  return state;
}

double largest_gap(const System& s, const State& state) {
  VectorXd phi;
  evaluate_phi(s, state.q, phi);
  return phi.size() ? phi.cwiseAbs().maxCoeff() : 0.0;
}

TEST(AsymmetricTop, Rk4KeepsMomentumAndEnergyTo1e9Over100Seconds) {
  const auto [s, start] = top(10.0);
  const State end = run("rk4", s, start, 1e-3, 100.0);
  EXPECT_LT(
      (angular_momentum(s, end) - angular_momentum(s, start)).norm() / angular_momentum(s, start).norm(),
      1e-9);
  EXPECT_NEAR(kinetic_energy(s, end) / kinetic_energy(s, start), 1.0, 1e-9);
}

TEST(AsymmetricTop, DriftsWithoutTheGyroscopicTerm) {  // the twin: w constant in body axes
  auto [s, state] = top(10.0);
  const Vector3d L = angular_momentum(s, state);
  for (int n = 0; n < 2000; ++n) advance(s, 1e-3, state.v, state.q, state.q);
  EXPECT_GT((angular_momentum(s, state) - L).norm() / L.norm(), 0.05);
}

TEST(AsymmetricTop, LeapfrogKeepsMomentumToRounding) {
  const auto [s, start] = top(10.0);
  const State end = run("leapfrog", s, start, 1e-3, 20.0);
  EXPECT_LT(
      (angular_momentum(s, end) - angular_momentum(s, start)).norm() / angular_momentum(s, start).norm(),
      1e-11);
}

TEST(AsymmetricTop, ImplicitEulerNeverGainsEnergyAtAFrameStep) {
  const auto [s, start] = top(10.0);
  for (const char* name : {"implicit_euler_notes", "implicit_euler_geometric", "implicit_euler_newton"}) {
    Integrator integrator = make_integrator(name, s);
    State state = start;
    History history;
    double energy = kinetic_energy(s, state);
    const double first = energy;
    const RunResult result =
        simulate(s, integrator, state, history,
                 {.dt = 1.0 / 60.0, .end_time = 10.0, .observer = [&](const State& at, const History&) {
                    EXPECT_LE(kinetic_energy(s, at), energy * (1.0 + 1e-14));
                    energy = kinetic_energy(s, at);
                    return true;
                  }});
    EXPECT_TRUE(result.status.ok());
    EXPECT_LT(energy, 0.99 * first) << name;
  }
}

TEST(Bodies, EveryIntegratorHasItsOrder) {
  const auto [s, start] = hung_brick();
  const double end = 0.5;
  const State exact = run("rk4", s, start, 2.5e-5, end);
  auto error = [&](const State& state) {
    return (state.q.head(3 * s.places()) - exact.q.head(3 * s.places())).norm() +
           (orientation(s.bodies[0], state.q) - orientation(s.bodies[0], exact.q)).norm();
  };
  for (const IntegratorInfo& method : integrator_list()) {
    const double dt = method.order == 4 ? 4e-3 : method.order == 2 ? 1e-3 : 2e-4;
    const double coarse = error(run(method.name, s, start, dt, end)),
                 fine = error(run(method.name, s, start, 0.5 * dt, end));
    EXPECT_NEAR(std::log2(coarse / fine), method.order, 0.1) << method.name << " " << coarse << " " << fine;
  }
}

TEST(HeavyTop, GivesEveryIntegratorItsOrder) {
  for (const char* spec : {"heavy_top:stiffness=300", "heavy_top"}) {
    const Model model = make_model(spec);
    const System& s = model.system;
    constexpr double kEnd = 0.25;
    const State exact = run("rk4", s, model.state, 2.5e-5, kEnd);
    for (const IntegratorInfo& method : integrator_list()) {
      if (!refusal(make_integrator(method.name, s), s).empty()) continue;  // explicit Euler and hard joints
      const double dt = method.order == 4 ? 4e-3 : method.order == 2 ? 2e-3 : 2e-4;
      const double coarse = position_error(s, run(method.name, s, model.state, dt, kEnd), exact),
                   fine = position_error(s, run(method.name, s, model.state, 0.5 * dt, kEnd), exact);
      EXPECT_NEAR(std::log2(coarse / fine), method.order, 0.1) << spec << " " << method.name << " " << coarse;
    }
  }
}

TEST(Bodies, PredictedLimitOfLeapfrogHoldsForABodyOnSprings) {
  SystemBuilder builder;  // at rest between four springs, of which the turning modes are the fastest
  const Anchor body = builder.add_body(brick(), {});
  for (double x : {-1.0, 1.0})
    for (double z : {-1.0, 1.0})
      builder.add(AnchorDistanceRow{{builder.add_world_point({0.75 * x, 0.4 * x * z, 0.35 * z}),
                                     {.body = body.body, .point = {0.25 * x, 0.15 * x * z, 0.05 * z}},
                                     1e3},
                                    Vector3d(0.5 * x, 0.25 * x * z, 0.3 * z).norm()});
  auto [s, start] = builder.build();
  const StabilityLimit limit = stability_limit_leapfrog(s, start);
  ASSERT_TRUE(std::isfinite(limit.dt)) << limit.why;
  start.v.tail<6>() = 1e-7 * Random(3).numbers(6);
  auto growth = [&](double dt) {
    Integrator leapfrog = make_integrator("leapfrog", s);
    State state = start;
    History history;
    double largest = 0.0;
    (void)simulate(s, leapfrog, state, history,
                   {.dt = dt, .end_time = 1500.0 * dt, .observer = [&](const State& at, const History&) {
                      largest = std::max(largest, (at.q - start.q).norm());
                      return largest < 1e-2;
                    }});
    return largest;
  };
  EXPECT_LT(growth(0.98 * limit.dt), 1e-4);
  EXPECT_GT(growth(1.02 * limit.dt), 1e-2);
}

TEST(Bodies, ImplicitLedgersClose) {
  for (double stiffness : {1e4, double(INFINITY)})
    for (const char* name : {"implicit_euler_notes", "implicit_euler_geometric", "implicit_euler_newton"}) {
      const auto [s, start] = jointed_bricks(4, stiffness, 0.01);
      std::vector<EnergyLedger> ledgers;
      (void)run(name, s, start, 0.01, 0.5, &ledgers);
      ASSERT_EQ(ledgers.size(), 50u);
      for (const EnergyLedger& ledger : ledgers)
        EXPECT_LT(std::abs(ledger.imbalance()), 1e-12 * ledger.magnitude()) << name << " " << stiffness;
    }
}

TEST(Bodies, ExplicitLedgersClose) {
  const auto [s, start] = hung_brick(40.0, 0.01);
  for (const char* name : {"explicit_euler", "leapfrog", "rk4"}) {
    std::vector<EnergyLedger> ledgers;
    (void)run(name, s, start, 0.001, 0.1, &ledgers);
    for (const EnergyLedger& ledger : ledgers)
      EXPECT_LT(std::abs(ledger.imbalance()), 1e-12 * ledger.magnitude()) << name;
  }
}

// Where one axis is masked the gyroscopic term acts about that axis alone: nothing of it is to be booked.
TEST(Bodies, ImplicitLedgersCloseWithPartlyMaskedSpins) {
  SystemBuilder builder;
  const Anchor body =
      builder.add_body(brick(), {.angular_velocity = {3.0, -2.0, 0.0}, .free_spin = kPlanarXY});
  const Anchor post = builder.add_world_point({0.5, 0.4, 0.3});
  builder.add(AnchorDistanceRow{{post, {.body = body.body, .point = {0.15, 0.1, 0.05}}, 50.0}, 0.4});
  const auto [s, start] = builder.build();
  for (const char* name : {"implicit_euler_notes", "implicit_euler_newton", "xpbd"}) {
    std::vector<EnergyLedger> ledgers;
    const State end = run(name, s, start, 0.01, 0.5, &ledgers);
    EXPECT_EQ(end.v[3 * s.bodies[0].spin + 2], 0.0) << name;
    ASSERT_GT((end.v - start.v).norm(), 0.1) << name;
    for (const EnergyLedger& ledger : ledgers)
      EXPECT_LT(std::abs(ledger.imbalance()), 1e-12 * ledger.magnitude()) << name;
  }
}

TEST(Bodies, RoutesAgreeOnHardJoints) {
  const auto [s, start] = jointed_bricks(12);
  Kkt kkt = test::implicit_euler_kkt(s, start, 0.01);
  VectorXd dense, y;
  for (const char* route : {"dense", "kkt", "dual", "auto"}) {
    LinearSolver solver(route);
    ASSERT_TRUE(solver.analyze(s, false).ok()) << route;
    ASSERT_TRUE(solver.factor(kkt).ok()) << route;
    VectorXd v;
    ASSERT_TRUE(solver.solve(kkt, v, y).status.ok()) << route;
    if (dense.size() == 0) dense = v;
    EXPECT_LT((v - dense).norm(), 1e-12 * dense.norm()) << route;
  }
}

TEST(Bodies, NewtonClosesHardJointsTo1e10) {
  const auto [s, start] = jointed_bricks(5);
  Integrator newton = make_integrator("implicit_euler_newton", s);
  State state = start;
  History history;
  double worst = 0.0;
  const RunResult result =
      simulate(s, newton, state, history,
               {.dt = 0.01, .end_time = 2.0, .observer = [&](const State& at, const History&) {
                  worst = std::max(worst, largest_gap(s, at));
                  return true;
                }});
  ASSERT_TRUE(result.status.ok()) << result.status.reason;
  ASSERT_GT((state.q - start.q).norm(), 0.3);  // it swung
  EXPECT_LT(worst, 1e-10);
}

TEST(Bodies, PositionErrorIsThatOfTheirPoints) {
  Random random(5);
  std::vector<PointMass> points;
  for (int i = 0; i < 6; ++i) points.push_back({random.uniform(0.2, 1.0), random.vector(0.5)});
  SystemBuilder builder;
  builder.add_body(point_masses("points", points), {});
  const auto [s, a] = builder.build();
  State b = a;
  VectorXd v(6);
  v << 1e-5, -2e-5, 3e-5, 2e-5, 4e-5, -1e-5;
  advance(s, 1.0, v, b.q, b.q);
  double sum = 0.0, mass = 0.0;
  for (const PointMass& point : points) {
    const Anchor at{.body = 0, .point = point.position};
    sum += point.mass * (position(s, at, b.q) - position(s, at, a.q)).squaredNorm();
    mass += point.mass;
  }
  EXPECT_NEAR(position_error(s, a, b) / std::sqrt(sum / mass), 1.0, 1e-4);  // quadratic in the turn
}

TEST(Bodies, RotationErrorIsTheAngleWhateverItsSize) {
  const auto [s, a] = top(1.0);
  for (double angle : {1e-10, 1e-3, 1.0, 3.0}) {
    State b = a;
    VectorXd v = VectorXd::Zero(6);
    v[5] = angle;
    advance(s, 1.0, v, b.q, b.q);
    EXPECT_NEAR(rotation_error(s, a.q, b.q) / (angle * angle * s.bodies[0].moments[2]), 1.0, 1e-5) << angle;
  }
}

TEST(Bodies, StepDoublingControlsTheTurnOfAFreeTop) {
  const auto [s, start] = top(10.0);
  const State exact = run("rk4", s, start, 1e-4, 1.0);
  auto error = [&](double tolerance) {
    Integrator integrator = make_integrator("rk4", s);
    State state = start;
    History history;
    EXPECT_TRUE(simulate_adaptive(s, integrator, state, history, {.tolerance = tolerance, .end_time = 1.0})
                    .status.ok());
    return position_error(s, state, exact);
  };
  const double rough = error(1e-4), fine = error(1e-7);
  EXPECT_LT(rough, 1e-3);
  EXPECT_LT(fine, 1e-6);
  EXPECT_GT(rough, 10.0 * fine);
}

TEST(Bodies, AShortLastStepGivesNoKick) {
  const auto [s, start] = jointed_bricks(2);
  for (const char* name : {"implicit_euler_notes", "implicit_euler_geometric", "implicit_euler_newton"})
    for (double rest : {1e-5, 1e-8}) {
      const State whole = run(name, s, start, 0.01, 0.5), more = run(name, s, start, 0.01, 0.5 + rest);
      EXPECT_NEAR(total_energy(s, more), total_energy(s, whole), 0.02 * kinetic_energy(s, whole))
          << name << " " << rest;
    }
}

TEST(Rk4OnJoints, HasOrderFourAndStaysClosedAtBothLevels) {
  const auto [s, start] = jointed_bricks(3);
  constexpr double kEnd = 0.5;
  const State exact = run("rk4", s, start, 2.5e-4, kEnd);
  auto error = [&](const State& state) {
    return (state.q.head(3 * s.places()) - exact.q.head(3 * s.places())).norm();
  };
  const State coarse = run("rk4", s, start, 5e-3, kEnd), fine = run("rk4", s, start, 2.5e-3, kEnd);
  EXPECT_NEAR(std::log2(error(coarse) / error(fine)), 4.0, 0.15) << error(coarse) << " " << error(fine);
  EXPECT_LT(largest_gap(s, coarse), 1e-14);
  Kkt kkt;
  kkt.prepare(s);
  VectorXd Jv;
  ASSERT_TRUE(kkt.evaluate(coarse.q).ok());
  kkt.multiply_jacobian(coarse.v, Jv);
  EXPECT_LT(Jv.cwiseAbs().maxCoeff(), 1e-13);
  // RATTLE comes to the same motion
  EXPECT_LT(error(run("leapfrog", s, start, 2.5e-4, kEnd)), 1e-5);
}

TEST(Rk4OnJoints, ReportsTheDriftItProjectsAway) {
  const auto [s, start] = jointed_bricks(3);
  auto drift = [&](double dt) {
    Integrator rk4 = make_integrator("rk4", s);
    State state = start;
    History history;
    EXPECT_TRUE(simulate(s, rk4, state, history, {.dt = dt, .end_time = 0.5}).status.ok());
    return counts(rk4);
  };
  const StepCounts coarse = drift(1e-2), fine = drift(5e-3);
  EXPECT_NEAR(std::log2(coarse.position_drift / fine.position_drift), 5.0, 0.7);  // a local error
  EXPECT_NEAR(std::log2(coarse.velocity_drift / fine.velocity_drift), 5.0, 0.7);
}

TEST(Rk4OnJoints, LedgerCloses) {
  const auto [s, start] = jointed_bricks(3);
  std::vector<EnergyLedger> ledgers;
  (void)run("rk4", s, start, 5e-3, 0.2, &ledgers);
  for (const EnergyLedger& ledger : ledgers)
    EXPECT_LT(std::abs(ledger.imbalance()), 1e-12 * ledger.magnitude());
}

TEST(Rattle, ClosesHardJointsInPositionAndVelocity) {
  const auto [s, start] = jointed_bricks(5);
  Integrator rattle = make_integrator("leapfrog", s);
  State state = start;
  History history;
  Kkt kkt;
  kkt.prepare(s);
  double gap = 0.0, rate = 0.0;
  VectorXd Jv;
  const RunResult result =
      simulate(s, rattle, state, history,
               {.dt = 0.005, .end_time = 2.0, .observer = [&](const State& at, const History&) {
                  gap = std::max(gap, largest_gap(s, at));
                  EXPECT_TRUE(kkt.evaluate(at.q).ok());
                  kkt.multiply_jacobian(at.v, Jv);
                  rate = std::max(rate, Jv.cwiseAbs().maxCoeff());
                  return true;
                }});
  ASSERT_TRUE(result.status.ok()) << result.status.reason;
  ASSERT_GT((state.q - start.q).norm(), 0.3);
  EXPECT_LT(gap, 1e-13);
  EXPECT_LT(rate, 1e-12);
}

TEST(Rattle, IsOfSecondOrder) {
  const auto [s, start] = jointed_bricks(3);
  const State exact = run("leapfrog", s, start, 1.25e-4, 0.4);
  auto error = [&](double dt) { return (run("leapfrog", s, start, dt, 0.4).q - exact.q).norm(); };
  EXPECT_NEAR(std::log2(error(4e-3) / error(2e-3)), 2.0, 0.1);
}

TEST(Rattle, KeepsTheEnergyOfATriplePendulumWithoutTrend) {
  const auto [s, start] = jointed_bricks(3);
  Integrator rattle = make_integrator("leapfrog", s);
  State state = start;
  History history;
  const double energy = total_energy(s, start);
  double early = 0.0, late = 0.0;
  const RunResult result =
      simulate(s, rattle, state, history,
               {.dt = 0.002, .end_time = 20.0, .observer = [&](const State& at, const History&) {
                  double& worst = at.t < 10.0 ? early : late;
                  worst = std::max(worst, std::abs(total_energy(s, at) - energy));
                  return true;
                }});
  ASSERT_TRUE(result.status.ok()) << result.status.reason;
  ASSERT_GT(early, 1e-6);
  EXPECT_LT(late, 3.0 * early);
}

TEST(Rattle, KeepsTheMomentaOfAFreeLinkedPair) {
  SystemBuilder builder;
  const Anchor one = builder.add_body(brick(), {.velocity = {0.1, 0, 0}, .angular_velocity = {1, 2, 3}});
  const Anchor two = builder.add_body(
      brick(), {.position = {0.5, 0, 0},
                .velocity = Vector3d(0.1, 0, 0) + Vector3d(1, 2, 3).cross(Vector3d(0.5, 0, 0)),
                .angular_velocity = {1, 2, 3}});
  builder.add(BallRow{
      {{.body = one.body, .point = {0.25, 0, 0}}, {.body = two.body, .point = {-0.25, 0, 0}}, INFINITY}});
  const auto [s, start] = builder.build();
  const State end = run("leapfrog", s, start, 0.01, 100.0);
  ASSERT_GT((end.q - start.q).norm(), 1.0);
  EXPECT_LT((linear_momentum(s, end) - linear_momentum(s, start)).norm(),
            1e-12 * linear_momentum(s, start).norm());
  EXPECT_LT((angular_momentum(s, end) - angular_momentum(s, start)).norm(),
            1e-10 * angular_momentum(s, start).norm());
}

TEST(Rattle, AgreesWithNewtonAsTheStepGoesToZero) {
  const auto [s, start] = jointed_bricks(2);
  const State rattle = run("leapfrog", s, start, 1e-3, 0.2);
  auto gap = [&](double dt) { return (run("implicit_euler_newton", s, start, dt, 0.2).q - rattle.q).norm(); };
  EXPECT_NEAR(std::log2(gap(1e-3) / gap(5e-4)), 1.0, 0.1);
}

TEST(Bodies, RigidJointsAreTheLimitOfStiffOnes) {
  const auto [rigid, start] = jointed_bricks(3);
  const State limit = run("implicit_euler_newton", rigid, start, 0.01, 0.3);
  auto distance = [&](double stiffness) {
    const auto [soft, begin] = jointed_bricks(3, stiffness);
    return (run("implicit_euler_newton", soft, begin, 0.01, 0.3).q - limit.q).norm();
  };
  const double slope = std::log10(distance(1e9) / distance(1e7)) / 2.0;
  EXPECT_NEAR(slope, -1.0, 0.05);
}

TEST(Bodies, NormalisedEulerTurnsSlower) {
  SystemBuilder builder;
  builder.add_body(brick(), {.angular_velocity = {0.0, 0.0, 5.0}});
  const auto [s, start] = builder.build();
  const State exact = run("implicit_euler_notes", s, start, 0.02, 1.0),
              euler = run("implicit_euler_notes", s, start, 0.02, 1.0, nullptr,
                          {.rotation_update = RotationUpdate::kNormalisedEuler});
  auto angle = [&](const State& state) {
    const Matrix3d R = orientation(s.bodies[0], state.q);
    return std::atan2(R(1, 0), R(0, 0));
  };
  const double turned = std::remainder(5.0, 2.0 * M_PI);
  EXPECT_NEAR(angle(exact), turned, 1e-12);
  EXPECT_NEAR(angle(euler), std::remainder(50.0 * 2.0 * std::atan(0.05), 2.0 * M_PI), 1e-12);
}

TEST(Bodies, PinnedAndPlanarBodiesStayExactly) {
  SystemBuilder builder;
  const Anchor wall = builder.add_body(brick(), {.free = kPinned, .free_spin = kPinned});
  const Anchor flat = builder.add_body(
      brick(), {.position = {0.5, 0, 0}, .angular_velocity = {0, 0, 1}, .free = kPlanarXY, .free_spin = 4});
  builder.add(BallRow{
      {{.body = wall.body, .point = {0.25, 0, 0}}, {.body = flat.body, .point = {-0.25, 0, 0}}, 100.0}});
  builder.set_gravity({0.0, -9.81, 2.0});
  const auto [s, start] = builder.build();
  EXPECT_EQ(s.free_count, 3);
  for (const IntegratorInfo& method : integrator_list()) {
    const State end = run(method.name, s, start, 1e-3, 0.2);
    EXPECT_EQ(end.q.segment<3>(0), start.q.segment<3>(0)) << method.name;
    EXPECT_EQ(end.q.segment<4>(s.bodies[0].quaternion), start.q.segment<4>(s.bodies[0].quaternion))
        << method.name;
    EXPECT_EQ(end.q[5], 0.0) << method.name;
    EXPECT_EQ(end.q[s.bodies[1].quaternion + 1], 0.0) << method.name;
  }
}

}  // namespace
}  // namespace feder
