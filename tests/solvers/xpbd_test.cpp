// Position based dynamics beside the methods it stands for: the linearised and the converged implicit step.
#include "solvers/xpbd.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/joints.h"
#include "models/catalog.h"
#include "models/slider_crank.h"
#include "solvers/simulate.h"
#include "solvers/threads.h"

namespace feder {
namespace {

State after(const System& system, const State& start, const std::string& integrator, double dt, int steps,
            const IntegratorOptions& options = {}) {
  Integrator method = make_integrator(integrator, system, options);
  State state = start;
  History history;
  EXPECT_TRUE(std::visit([](auto& i) { return i.prepare(); }, method).ok());
  for (int n = 0; n < steps; ++n) {
    const Status status = std::visit([&](auto& i) { return i.step(dt, state, history, nullptr); }, method);
    EXPECT_TRUE(status.ok()) << integrator << " step " << n << ": " << status.reason;
  }
  return state;
}

State after(const Model& model, const std::string& integrator, double dt, int steps,
            const IntegratorOptions& options = {}) {
  return after(model.system, model.state, integrator, dt, steps, options);
}

// By a newly made integrator.
Status one_step(const System& system, double dt, const IntegratorOptions& options, State& state,
                History& history, EnergyLedger* ledger = nullptr) {
  Xpbd xpbd(system, options);
  if (Status status = xpbd.prepare(); !status.ok()) return status;
  return xpbd.step(dt, state, history, ledger);
}

double distance(const State& a, const State& b) {
  return (a.q - b.q).lpNorm<Eigen::Infinity>();
}

double largest_gap(const Model& model, const State& state) {
  VectorXd phi;
  evaluate_phi(model.system, state.q, phi);
  return phi.lpNorm<Eigen::Infinity>();
}

// Of the scene's length, after three steps; the steps themselves move it by more than 1e-4.
TEST(Xpbd, WithFrozenRowsAndEnoughSweepsIsTheLinearisedImplicitStep) {
  for (const char* spec : {"S1(20)", "S1h(20)", "S2(8)", "S3c(10)"}) {
    const Model model = make_model(spec);
    const State linear = after(model, "implicit_euler_notes", 1.0 / 60.0, 3);
    const State few = after(model, "xpbd", 1.0 / 60.0, 3, {.sweeps = 20, .frozen_rows = true});
    const State many = after(model, "xpbd", 1.0 / 60.0, 3, {.sweeps = 1000000, .frozen_rows = true});
    ASSERT_GT(distance(linear, model.state), 1e-4 * model.scene_length) << spec;
    EXPECT_LT(distance(many, linear), 1e-9 * model.scene_length) << spec;
    EXPECT_GT(distance(few, linear), 1e-6 * model.scene_length) << spec;  // it was the sweeps
  }
}

// Notes H6: with J updated as usual the limit is another method, between first and second order away from
// Newton's.
TEST(Xpbd, WithRowsUpdatedApproachesNewtonAsTheStepShrinks) {
  const Model model = make_model("S1(10)");
  std::vector<double> apart;
  for (int halvings = 0; halvings < 3; ++halvings) {
    const int steps = 6 << halvings;
    const double dt = 0.1 / steps;
    apart.push_back(distance(after(model, "implicit_euler_newton", dt, steps),
                             after(model, "xpbd", dt, steps, {.sweeps = 100000})));
  }
  ASSERT_GT(apart[0], 1e-5 * model.scene_length);
  EXPECT_LT(apart[1], 0.7 * apart[0]);
  EXPECT_LT(apart[2], 0.7 * apart[1]);
}

// Notes H5, slip 7: one rod, one sweep.
TEST(Xpbd, ClosesOneRodInOneSweepAndWithTheNotesHalvedWeightsHalf) {
  SystemBuilder builder;
  const Anchor a = builder.add_particle(2.0, {0, 0, 0}), b = builder.add_particle(5.0, {1.5, 0, 0});
  builder.add_distance(a, b, {kRigid, 0.0}, 1.0);
  const auto [system, start] = builder.build();
  auto gap = [&](RowWeights weights, State& state) {
    Integrator xpbd = make_integrator("xpbd", system, {.sweeps = 1, .row_weights = weights});
    History history;
    EXPECT_TRUE(simulate(system, xpbd, state, history, {.dt = 0.1, .end_time = 0.1}).status.ok());
    return (state.q.tail<3>() - state.q.head<3>()).norm() - 1.0;
  };
  State closed = start, halved = start;
  EXPECT_NEAR(gap(RowWeights::kMass, closed), 0.0, 1e-15);
  EXPECT_NEAR(gap(RowWeights::kHalved, halved), 0.25, 1e-15);
  // the centre of mass stays
  EXPECT_NEAR(2.0 * closed.q[0] + 5.0 * closed.q[3], 7.5, 1e-14);
}

// Notes H6. A hanging chain of 20 links of 1 N/mm at rest, after damped settling.
TEST(Xpbd, IsSofterThanItsSpringsUntilTheSweepsConverge) {
  auto stretch = [](int sweeps) {
    SystemBuilder builder;
    Anchor last = builder.add_world_point({0, 0, 0});
    for (int i = 1; i <= 20; ++i) {
      const Anchor next = builder.add_particle(0.05, {0, -0.1 * i, 0});
      builder.add_distance(last, next, {1e5, 0.0}, 0.1);
      last = next;
    }
    builder.set_gravity({0, -9.81, 0});
    builder.set_drag(0.5);
    auto [system, state] = builder.build();
    Integrator xpbd = make_integrator("xpbd", system, {.sweeps = sweeps});
    History history;
    EXPECT_TRUE(simulate(system, xpbd, state, history, {.dt = 1.0 / 60.0, .end_time = 20.0}).status.ok());
    return -state.q[state.q.size() - 2] - 2.0;
  };
  // sum of i m g / d over the links
  const double exact = 0.05 * 9.81 * 210.0 / 1e5;
  const double one = stretch(1), ten = stretch(10), many = stretch(3000);
  EXPECT_NEAR(many, exact, 1e-6 * exact);
  EXPECT_GT(one, 10.0 * exact);
  EXPECT_GT(ten, 1.5 * exact);
  EXPECT_LT(ten, one);
}

TEST(Xpbd, ClosesJointsOfBodiesWithSweepsAndSubsteps) {
  const Model model = make_model("S3c(20)");
  const double few = largest_gap(model, after(model, "xpbd", 1.0 / 60.0, 15, {.sweeps = 5})),
               many = largest_gap(model, after(model, "xpbd", 1.0 / 60.0, 15, {.sweeps = 500})),
               substeps =
                   largest_gap(model, after(model, "xpbd", 1.0 / 60.0, 15, {.sweeps = 1, .substeps = 20}));
  EXPECT_GT(few, 1e-3);
  EXPECT_LT(many, 0.1 * few);
  EXPECT_LT(substeps, 0.5 * few);  // four times the work
}

TEST(Xpbd, SubstepsAreShorterSteps) {
  const Model model = make_model("S2(6)");
  const State whole = after(model, "xpbd", 0.01, 4, {.sweeps = 3, .substeps = 5}),
              parts = after(model, "xpbd", 0.01 / 5, 20, {.sweeps = 3});
  ASSERT_GT(distance(whole, model.state), 1e-3);
  EXPECT_LT(distance(whole, parts), 1e-13);
}

TEST(Xpbd, GivesTheSameBitsOnOneAndTwoThreads) {
  const Model model = make_model("S2(100)");
  set_threads(1);
  const State one = after(model, "xpbd", 1.0 / 60.0, 2, {.sweeps = 3});
  set_threads(2);
  const State two = after(model, "xpbd", 1.0 / 60.0, 2, {.sweeps = 3});
  set_threads(1);
  EXPECT_EQ(one.q, two.q);
  EXPECT_EQ(one.v, two.v);
}

Model motor_crank() {
  SliderCrank crank;
  crank.drive = CrankDrive::kMotor;
  return make_slider_crank(crank);
}

// The motor leaves no freedom: only the rows decide, and both methods close them.
TEST(Xpbd, WithConvergedSweepsFollowsAMotorAsNewtonDoes) {
  const Model model = motor_crank();
  const State newton = after(model, "implicit_euler_newton", 0.005, 10),
              few = after(model, "xpbd", 0.005, 10, {.sweeps = 5}),
              many = after(model, "xpbd", 0.005, 10, {.sweeps = 5000});
  ASSERT_GT(distance(newton, model.state), 0.1);
  EXPECT_GT(distance(few, newton), 1e-5);    // 3.7e-4
  EXPECT_LT(distance(many, newton), 1e-11);  // 1e-13
}

// A rod with damping from a moving point, a spring, dampers with and without rest length, drag and a node of
// a plane.
SystemBuilder::Built driven_chain() {
  SystemBuilder builder;
  const Anchor hand =
      builder.add_moving_point({[](double t) { return Vector3d(0.1 * std::sin(20.0 * t), 0, 0); },
                                [](double t) { return Vector3d(2.0 * std::cos(20.0 * t), 0, 0); },
                                [](double t) { return Vector3d(-40.0 * std::sin(20.0 * t), 0, 0); }});
  const Anchor a = builder.add_particle(1.0, {1, 0, 0}), b = builder.add_particle(0.5, {2, 0, 0}),
               c = builder.add_particle(0.7, {2.5, 0.4, 0}, {0, 0, 0}, FreeMask{3});
  builder.add_distance(hand, a, {kRigid, 0.02}, 0.9);
  builder.add_distance(a, b, {500.0, 0.03}, 0.8);
  builder.add_distance(b, c, {0.0, 0.0, 5.0}, 0.3);
  builder.add_distance(a, c, {200.0, 0.0, 1.0}, 0.0);
  builder.set_gravity({0, -9.81, 0.5});
  builder.set_drag(0.3);
  return builder.build();
}

TEST(Xpbd, WithMovingPointsDampingAndMasksApproachesNewtonAsTheStepShrinks) {
  const auto [system, start] = driven_chain();
  std::vector<double> apart;
  for (int steps : {20, 40, 80}) {
    const double dt = 0.2 / steps;
    const State frozen = after(system, start, "xpbd", dt, steps, {.sweeps = 20000, .frozen_rows = true});
    EXPECT_LT(distance(frozen, after(system, start, "implicit_euler_notes", dt, steps)), 1e-13);  // 8e-16
    apart.push_back(distance(after(system, start, "implicit_euler_newton", dt, steps),
                             after(system, start, "xpbd", dt, steps, {.sweeps = 20000})));
  }
  ASSERT_GT(apart[0], 1e-3);            // 7.4e-3
  EXPECT_LT(apart[1], 0.4 * apart[0]);  // 0.285
  EXPECT_LT(apart[2], 0.4 * apart[1]);  // 0.268
}

// A motor throws a wheel back: without its row the wheel would turn by 2 rad, with it by -1.5.
TEST(Xpbd, CountsTurnsFromTheStartOfTheStep) {
  SystemBuilder builder;
  SystemBuilder::BodyStart start;
  start.angular_velocity = {0, 0, 20.0};
  const Anchor wheel = builder.add_body(solid_cylinder("wheel", 1.0, 0.1, 0.05), start);
  add_hinge(builder, {}, wheel, {0, 0, 0}, {0, 0, 1});
  add_turn(builder, {}, wheel, {0, 0, 1}, {kRigid}, steady_target(0.0, -15.0));
  const auto [system, state] = builder.build();
  const State newton = after(system, state, "implicit_euler_newton", 0.1, 1),
              swept = after(system, state, "xpbd", 0.1, 1, {.sweeps = 100});
  EXPECT_NEAR(newton.v.lpNorm<Eigen::Infinity>(), 15.0, 1e-9);
  EXPECT_LT((swept.v - newton.v).lpNorm<Eigen::Infinity>(), 1e-9);
  EXPECT_LT(distance(swept, newton), 1e-10);
}

// Two sweeps leave the rods of a chain open; a last step of a microsecond shall not close them in that time.
TEST(Xpbd, DoesNotThrowOpenRowsShutInAShorterStep) {
  const Model model = make_model("S1h(20)");
  for (const bool frozen : {false, true}) {
    const IntegratorOptions options{.sweeps = 2, .frozen_rows = frozen};
    Integrator xpbd = make_integrator("xpbd", model.system, options);
    State state = model.state, last;
    History history;
    RunOptions run{.dt = 1.0 / 60.0, .end_time = 5.0 / 60.0 + 1e-6};
    run.observer = [&](const State& now, const History&) {
      if (now.t < run.end_time) last = now;
      return true;
    };
    ASSERT_TRUE(simulate(model.system, xpbd, state, history, run).status.ok());
    ASSERT_GT(largest_gap(model, last), 1e-3);  // over 1e-6 s: 1e3 m/s
    EXPECT_LT((state.v - last.v).lpNorm<Eigen::Infinity>(),
              last.v.lpNorm<Eigen::Infinity>());  // 0.45 of 0.82
  }
}

TEST(Xpbd, SpringsThatCannotMoveTheirNodesStillCarryTheirForce) {
  SystemBuilder builder;
  const Anchor rail = builder.add_particle(1.0, {0, 0, 0}, {0, 0, 0}, FreeMask{1});
  const Anchor above = builder.add_world_point({0, 1, 0}), aside = builder.add_world_point({1, 1, 0});
  const int across = builder.add_distance(rail, above, {100.0, 0.0}, 0.8),
            fixed = builder.add_distance(above, aside, {50.0, 0.0}, 0.9);
  auto [system, state] = builder.build();
  History history;
  ASSERT_TRUE(one_step(system, 0.1, {}, state, history).ok());
  EXPECT_NEAR(history.lambda[system.row_of_id[across]], -20.0, 1e-12);
  EXPECT_NEAR(history.lambda[system.row_of_id[fixed]], -5.0, 1e-12);
}

// The velocity leads to where both points coincide: no direction. A rod is degenerate there, a damped spring
// without rest length is not.
TEST(Xpbd, OnlyRowsWithRestLengthAreDegenerateAtLengthZero) {
  for (const double rest : {0.0, 1.0}) {
    SystemBuilder builder;
    const Anchor fixed = builder.add_world_point({0, 0, 0}),
                 free = builder.add_particle(1.0, {1, 0, 0}, {-2, 0, 0});
    builder.add_distance(fixed, free, {1.0, 0.5}, rest);
    auto [system, state] = builder.build();
    const State start = state;
    History history;
    const Status status = one_step(system, 0.5, {}, state, history);
    EXPECT_EQ(status.code, rest > 0.0 ? StatusCode::kSingular : StatusCode::kOk);
    if (rest > 0.0) EXPECT_NE(status.reason.find("distance row 0"), std::string::npos) << status.reason;
    EXPECT_EQ(state.q[3], rest > 0.0 ? start.q[3] : 0.0);
  }
}

TEST(Xpbd, LeavesTheStateAsItWasWhenALaterSubstepFails) {
  SystemBuilder builder;
  builder.add_particle(1.0, {0, 0, 0}, {1, 0, 0});
  UserForce force;
  force.force = [](double t, const VectorXd&, const VectorXd&, VectorXd& f) {
    if (t > 0.02) f[0] = std::nan("");
  };
  builder.set_user_force(force);
  auto [system, state] = builder.build();
  const State start = state;
  History history;
  EXPECT_EQ(one_step(system, 0.05, {.substeps = 5}, state, history).code, StatusCode::kNonFinite);
  EXPECT_EQ(state.t, start.t);
  EXPECT_EQ(state.q, start.q);
  EXPECT_EQ(state.v, start.v);
  EXPECT_EQ(history.last_dt, 0.0);
}

TEST(Xpbd, GoesOnBitwiseWhereARunWasSaved) {
  const Model model = motor_crank();
  const IntegratorOptions options{.sweeps = 3, .substeps = 4};
  State whole = model.state, parts = model.state;
  History history, saved;
  Xpbd xpbd(model.system, options);
  ASSERT_TRUE(xpbd.prepare().ok());
  for (const double dt : {0.004, 0.01, 0.002, 0.004}) {
    ASSERT_TRUE(xpbd.step(dt, whole, history, nullptr).ok());
    ASSERT_TRUE(one_step(model.system, dt, options, parts, saved).ok());  // by a new one
  }
  ASSERT_GT(distance(whole, model.state), 0.1);
  EXPECT_EQ(whole.q, parts.q);
  EXPECT_EQ(whole.v, parts.v);
}

TEST(Xpbd, ClosesItsLedgerOverSubsteps) {
  for (const char* spec : {"flexible_linkage", "S3c(10)", "S2(5)"}) {
    const Model model = make_model(spec);
    Xpbd xpbd(model.system, {.sweeps = 4, .substeps = 5});
    ASSERT_TRUE(xpbd.prepare().ok());
    State state = model.state;
    History history;
    EnergyLedger ledger;
    for (int n = 0; n < 5; ++n) {
      ASSERT_TRUE(xpbd.step(0.01, state, history, &ledger).ok());
      ASSERT_GT(std::abs(ledger.row_work), 1e-7 * ledger.magnitude()) << spec;
      EXPECT_LT(std::abs(ledger.imbalance()), 1e-13 * ledger.magnitude()) << spec;  // 1.4e-14
    }
  }
}

TEST(Xpbd, GivesBodiesAndBooksTheSameBitsOnOneAndTwoThreads) {
  const Model model = make_model("S3c(5000)");
  State state[2] = {model.state, model.state};
  EnergyLedger ledger[2];
  History history;
  for (int i : {0, 1}) {
    set_threads(i + 1);
    EXPECT_TRUE(one_step(model.system, 1.0 / 60.0, {.sweeps = 3}, state[i], history, &ledger[i]).ok());
  }
  set_threads(1);
  EXPECT_EQ(state[0].q, state[1].q);
  EXPECT_EQ(state[0].v, state[1].v);
  EXPECT_EQ(ledger[0].row_work, ledger[1].row_work);
}

}  // namespace
}  // namespace feder
