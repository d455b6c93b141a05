// Runs of scenes with contacts against their closed forms and conserved quantities.
#include <gtest/gtest.h>

#include <cmath>

#include "engine/body.h"
#include "engine/energy.h"
#include "models/bouncing_ball.h"
#include "models/catalog.h"
#include "models/drop.h"
#include "models/ladder.h"
#include "models/stack.h"
#include "solvers/simulate.h"
#include "tests/support/campaign.h"

namespace feder {
namespace {

const char* const kMethod = "implicit_euler_notes";

class Trial {
 public:
  explicit Trial(Model model_given, const char* method = kMethod)
      : model(std::move(model_given)),
        state(model.state),
        integrator(make_integrator(method, model.system)) {}
  explicit Trial(const std::string& spec) : Trial(make_model(spec)) {}
  Trial(const Trial&) = delete;

  Trial& to(double end, double dt) {
    const RunResult result =
        simulate(model.system, integrator, state, history, {.dt = dt, .end_time = end, .ledgers = &ledgers});
    EXPECT_TRUE(result.status.ok()) << model.name << ": " << result.status.reason;
    return *this;
  }
  Trial& to_the_end(double steps) { return to(model.end_time, model.end_time / steps); }
  Vector3d centre(int body = 0) const { return state.q.segment<3>(3 * model.system.bodies[body].centre); }
  /// Largest distance of a centre from where the closed form has it.
  double error() const {
    const State exact = model.exact(state.t);
    double worst = 0.0;
    for (const Body& b : model.system.bodies)
      worst = std::max(worst, (state.q.segment<3>(3 * b.centre) - exact.q.segment<3>(3 * b.centre)).norm());
    return worst;
  }
  const ContactCounts& counts() { return std::get<ImplicitEulerNotes>(integrator).contacts()->counts(); }

  Model model;
  State state;
  History history;
  Integrator integrator;
  std::vector<EnergyLedger> ledgers;
};

// Error at the end of runs of about so many steps: on average, for it jumps with where in its step a box
// turns back.
double mean_error(const std::string& spec, double steps) {
  constexpr int kRuns = 8;
  double sum = 0.0;
  for (int i = 0; i < kRuns; ++i) sum += Trial(spec).to_the_end(std::round(steps * (1.0 + i / 16.0))).error();
  return sum / kRuns;
}

// ---- Sliding, rolling, leaning

class SlidingAndRolling : public testing::TestWithParam<const char*> {};

TEST_P(SlidingAndRolling, AgreesWithItsClosedForm) {
  Trial run(GetParam());
  run.to_the_end(8000);
  double way = 0.0;
  for (int i = 1; i <= 10; ++i)
    way = std::max(way, (run.model.exact(0.1 * i * run.model.end_time).q - run.model.state.q).norm());
  ASSERT_GT(way, 0.1);
  EXPECT_LT(run.error(), 1e-3 * way);  // at most 0.54e-3 way
}

TEST_P(SlidingAndRolling, IsFirstOrder) {
  const double coarse = mean_error(GetParam(), 200), fine = mean_error(GetParam(), 1600),
               measured = std::log2(coarse / fine) / 3.0;
  EXPECT_GT(measured, 0.9);  // 0.9985 to 0.9995; turning back 1.02
  EXPECT_LT(measured, 1.1);
}

INSTANTIATE_TEST_SUITE_P(Scenes, SlidingAndRolling,
                         testing::Values("incline", "incline:speed=-2,friction=0.2", "rolling_ball",
                                         "rolling_ball:hollow=0.9", "rolling_ball:speed=-1,spin=30", "ladder",
                                         "ladder:angle=0.8"));

TEST(Incline, RestsExactlyBelowTheAngleOfFriction) {
  Trial run("incline:angle=0.5,friction=0.5464");  // tan(0.5) = 0.54630
  run.to_the_end(1000);
  EXPECT_LT(run.error(), 1e-12);  // 1.1e-15
}

TEST(RollingBall, KeepsFiveSevenths) {
  Trial run("rolling_ball");
  run.to_the_end(300);
  const Body& b = run.model.system.bodies[0];
  EXPECT_NEAR(run.state.v[3 * b.centre], 2.0 * 5.0 / 7.0, 1e-12);  // 9e-14
  EXPECT_NEAR(angular_velocity(b, run.state).z(), -2.0 * 5.0 / 7.0 / 0.1, 1e-11);
}

TEST(Ladder, StandsAboveTheThresholdAndSlidesBelow) {
  for (const double wall : {0.0, 0.3})
    for (const double angle : {0.7, 1.2}) {
      Ladder o{.angle = angle, .wall_friction = wall};
      const double threshold = ladder_threshold(o);
      const auto moved = [&](double friction) {
        o.floor_friction = friction;
        Trial run(make_ladder(o));
        run.to(0.5, 1e-3);
        return (run.state.q - run.model.state.q).norm();
      };
      EXPECT_LT(moved(1.001 * threshold), 1e-9) << wall << " " << angle;  // 1.8e-13
      EXPECT_GT(moved(0.999 * threshold), 1e-4) << wall << " " << angle;  // 4.2e-4
    }
}

// Height of the top, as a fraction of the start, where the wall (collider 1) pushes for the last time.
double leaving_height(const Ladder& o, double steps) {
  Trial run(make_ladder(o));
  double height = 1.0;
  bool on_wall = true;
  const auto look = [&](const State& at, const History& history) {
    on_wall = false;
    for (int i = 0; i + 6 <= history.contacts.size(); i += 6) on_wall = on_wall || history.contacts[i] == 1.0;
    if (on_wall)
      height =
          (at.q[3 * run.model.system.bodies[0].centre + 1] - o.radius) / (0.5 * o.length * std::sin(o.angle));
    return on_wall;
  };
  const double end = run.model.end_time;
  (void)simulate(run.model.system, run.integrator, run.state, run.history,
                 {.dt = end / steps, .end_time = 1.3 * end, .observer = look});
  EXPECT_FALSE(on_wall);
  return height;
}

TEST(Ladder, LeavesTheWallAtTwoThirdsOfItsHeight) {
  const Ladder o{.angle = 1.2};
  EXPECT_NEAR(leaving_height(o, 4000), 2.0 / 3.0, 1e-3);  // 1.3e-4
}

TEST(Ladder, LeavesTheWallWithAnErrorOfFirstOrder) {
  const Ladder o{.angle = 1.2};
  std::vector<double> errors;
  for (double steps : {250.0, 1000.0, 4000.0})
    errors.push_back(std::abs(leaving_height(o, steps) - 2.0 / 3.0));
  for (int i = 0; i < 2; ++i) {
    const double measured = 0.5 * std::log2(errors[i] / errors[i + 1]);
    EXPECT_GT(measured, 0.9);  // 0.997, 0.999
    EXPECT_LT(measured, 1.1);
  }
}

// ---- Resting

// Drift of any centre and any turn of a stack after so many steps.
double drift(const Stack& o, int steps) {
  constexpr double kStep = 5e-3;  // [s]
  Trial run(make_stack(o));
  run.model.end_time = steps * kStep;
  const RunResult result = simulate(run.model.system, run.integrator, run.state, run.history,
                                    {.dt = kStep, .end_time = run.model.end_time});
  EXPECT_TRUE(result.status.ok()) << result.status.reason;
  return (run.state.q - run.model.state.q).cwiseAbs().maxCoeff();
}

TEST(StackCampaign, OfTenRests) {
  EXPECT_LT(drift({.n = 10}, test::campaign_cases(100'000)), 1e-6);  // 2.1e-12
}

TEST(StackCampaign, RestsUnderATopTenThousandTimesHeavier) {
  for (int n : {2, 5})
    EXPECT_LT(drift({.n = n, .ratio = 1e4}, test::campaign_cases(100'000)), 1e-6)
        << n;  // 1.0e-11 for 2, 2.1e-12 for 5
}

TEST(StackCampaign, RestsUnderATopTenThousandTimesLighter) {
  EXPECT_LT(drift({.n = 5, .ratio = 1e-4}, test::campaign_cases(100'000)), 1e-6);  // 6e-13
}

// ---- Impacts within the step

TEST(Drop, ConvergesToItsClosedForm) {
  for (const char* spec : {"drop:start=face", "drop:start=edge", "drop:start=corner", "drop:restitution=1"}) {
    Trial coarse(spec), fine(spec);
    const double at_1000 = coarse.to_the_end(1000).error(), at_16000 = fine.to_the_end(16000).error();
    EXPECT_LT(at_1000, 0.02) << spec;            // at most 1.6e-3
    EXPECT_LT(at_16000, 0.2 * at_1000) << spec;  // at most 0.05; 1/16 on average
  }
}

TEST(Drop, ImpactTakesTheImpulseOfNotesD3) {
  for (const DropStart start : {DropStart::kEdge, DropStart::kCorner}) {
    const Drop o{.start = start};
    const DropImpact hit = drop_impact(o);
    Trial run(make_drop(o));
    run.to(hit.time + 1e-3, 1e-5);
    const Body& b = run.model.system.bodies[0];
    EXPECT_NEAR(angular_velocity(b, run.state).z() / hit.spin, 1.0, 1e-4);                      // 3.9e-6
    EXPECT_NEAR(run.state.v[3 * b.centre + 1] / (hit.velocity - 1e-3 * o.gravity), 1.0, 1e-3);  // 1.8e-5
  }
}

TEST(BouncingBall, ComesToRestAndRolls) {
  Trial coarse("bouncing_ball:speed=1,friction=0.3"), fine("bouncing_ball:speed=1,friction=0.3");
  const double at_2000 = coarse.to_the_end(2000).error(), at_32000 = fine.to_the_end(32000).error();
  EXPECT_LT(at_2000, 0.05);             // 0.030
  EXPECT_LT(at_32000, 0.15 * at_2000);  // 0.021
  EXPECT_NEAR(fine.centre().y(), 0.1, 1e-9);
}

TEST(Cradle, HandsTheMomentumToTheLastBall) {
  Trial run("cradle:n=5,angle=0.3,gap=1e-3");
  const double quarter = 0.25 * 2.0 * 3.14159265 / std::sqrt(9.81);
  run.to(1.25 * quarter, 2e-5);
  const double speed = std::sqrt(2.0 * 9.81 * (1.0 - std::cos(0.3)));
  for (int ball = 0; ball < 4; ++ball) EXPECT_LT(std::abs(run.state.v[3 * (2 * ball + 1)]), 0.02 * speed);  //
  EXPECT_GT(run.state.v[3 * 9], 0.85 * speed);  // 0.93
}

// ---- Cloths

TEST(ClothDrop, StaysOutsideTheObstacle) {
  for (const char* spec : {"cloth_drop:n=8", "cloth_drop:n=8,obstacle=torus"}) {
    Trial run(spec);
    run.to_the_end(300);
    EXPECT_GT(run.counts().contacts, 1000) << spec;
    EXPECT_LT(run.counts().deepest, 1e-7) << spec;  // 6.8e-13 and 1.2e-9
  }
}

TEST(ClothDrop, HangsOnTheBall) {
  Trial run("cloth_drop:n=8,friction=0.5,drag=0.02");
  run.to_the_end(600);
  Vector3d mean = Vector3d::Zero();
  for (int i = 0; i < 64; ++i) mean += run.state.q.segment<3>(3 * i) / 64.0;
  EXPECT_GT(mean.y(), -0.3);
  EXPECT_LT(std::hypot(mean.x(), mean.z()), 1e-6);  // as symmetric as it started
}

// ---- Meshes

TEST(MeshCollision, KeepsTheMomentum) {
  Trial run("mesh_collision:detail=8,ratio=3");
  run.to_the_end(300);
  const Vector3d before = linear_momentum(run.model.system, run.model.state);
  ASSERT_GT(run.counts().contacts, 0);
  const int first = 3 * run.model.system.bodies[0].centre;
  ASSERT_GT((run.state.v.segment<3>(first) - run.model.state.v.segment<3>(first)).norm(), 0.1);
  EXPECT_LT((linear_momentum(run.model.system, run.state) - before).norm(), 1e-12 * before.norm());  //
  EXPECT_LT(kinetic_energy(run.model.system, run.state), kinetic_energy(run.model.system, run.model.state));
}

// ---- What holds for every scene

TEST(Contacts, LedgerClosesInEveryScene) {
  int scenes = 0;
  for (const ModelInfo& info : catalog()) {
    Model model = make_model(info.name);
    if (model.system.colliders.empty()) continue;
    ++scenes;
    Trial run(std::move(model));
    run.to_the_end(200);
    double worst = 0.0, largest = 0.0;
    for (const EnergyLedger& ledger : run.ledgers) {
      worst = std::max(worst, std::abs(ledger.imbalance()));
      largest = std::max(largest, ledger.magnitude());
    }
    EXPECT_LT(worst, 1e-10 * largest)
        << info.name;  // 2e-17 to 2e-14; cloth_drop, whose contacts are held iteratively, 1.7e-11
  }
  EXPECT_GE(scenes, 9);
}

TEST(Contacts, KeepWhatTheirSceneConserves) {
  for (const char* spec : {"rolling_ball", "drop", "drop:start=edge"}) {
    Trial run(spec);
    run.to_the_end(500);
    for (const Conserved& c : run.model.conserved)
      EXPECT_NEAR(c.value(run.model.system, run.state), c.value(run.model.system, run.model.state), 1e-12)
          << spec << " " << c.name;  //
  }
}

TEST(Contacts, AResumedRunIsBitwiseTheSame) {
  for (const char* spec : {"stack:n=3", "drop:friction=0.4", "cloth_drop:n=6", "cradle"}) {
    Trial whole(spec), halves(spec);
    const double dt = whole.model.end_time / 256.0;  // a power of two: the times are exact
    whole.to(256.0 * dt, dt);
    halves.to(128.0 * dt, dt);
    ASSERT_GE(halves.history.contacts.size(), std::string(spec) == "stack:n=3" ? 6 : 0);
    Trial rest(spec);
    rest.state = halves.state, rest.history = halves.history;
    rest.to(256.0 * dt, dt);
    EXPECT_TRUE(rest.state.q == whole.state.q && rest.state.v == whole.state.v) << spec;
  }
}

TEST(Contacts, IntegratorsThatDoNotSeeThemRefuseByName) {
  const Model model = make_model("incline");
  int refused = 0;
  for (const IntegratorInfo& each : integrator_list()) {
    if (each.contacts) continue;
    ++refused;
    Integrator integrator = make_integrator(each.name, model.system);
    EXPECT_NE(refusal(integrator, model.system).find(each.name), std::string::npos) << each.name;
    State state = model.state;
    History history;
    const RunResult result =
        simulate(model.system, integrator, state, history, {.dt = 0.01, .end_time = 0.1});
    EXPECT_EQ(result.status.code, StatusCode::kRefused) << each.name;
    EXPECT_EQ(result.steps, 0) << each.name;
  }
  EXPECT_GE(refused, 4);
}

// A ball, a box and a capsule fall on each other and on the floor; colliders in the given order.
State heap_after(const std::vector<int>& collider_order, double end) {
  SystemBuilder builder;
  const Anchor floor = builder.add_world_point(Vector3d::Zero());
  const Anchor ball = builder.add_body(solid_sphere("ball", 1.0, 0.1), {.position = {0.02, 0.0, 0.12}});
  const Anchor box = builder.add_body(solid_box("box", 2.0, {0.4, 0.3, 0.1}),
                                      {.position = {0.05, 0.01, 0.3}, .angular_velocity = {0.3, 0.5, -0.2}});
  const Anchor bar = builder.add_body(solid_cylinder("bar", 0.7, 0.05, 0.4),
                                      {.position = {0.0, 0.0, 0.7}, .angular_velocity = {1.0, 0.0, 0.4}});
  const Surface surface{0.4, 0.2};
  for (int which : collider_order) {
    if (which == 0) builder.add_collider(floor, HalfSpaceShape{}, surface);
    if (which == 1) builder.add_collider(ball, SphereShape{0.1}, surface);
    if (which == 2) builder.add_collider(box, BoxShape{{0.2, 0.15, 0.05}}, surface);
    if (which == 3) builder.add_collider(bar, CapsuleShape{0.05, 0.2}, surface);
  }
  builder.set_gravity({0.0, 0.0, -9.81});
  auto [system, state] = builder.build();
  Model model{"heap", std::move(system), std::move(state)};
  Trial run(std::move(model));
  run.to(end, 1e-3);
  EXPECT_GT(run.counts().contacts, 100);
  return run.state;
}

TEST(Contacts, OrderOfCollidersChangesNothingButRounding) {
  const State first = heap_after({0, 1, 2, 3}, 0.3);
  for (const std::vector<int>& other : {std::vector{3, 2, 1, 0}, std::vector{2, 0, 3, 1}}) {
    const State again = heap_after(other, 0.3);
    EXPECT_LT((again.q - first.q).cwiseAbs().maxCoeff(), 1e-12);  // 2.2e-16
    EXPECT_LT((again.v - first.v).cwiseAbs().maxCoeff(), 1e-10);  // 8.3e-14
  }
}

}  // namespace
}  // namespace feder
