// Time keeping, divergence, and step-size control.
#include "solvers/simulate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/check.h"
#include "models/catalog.h"
#include "tests/support/random.h"

namespace feder {
namespace {

TEST(StepCount, RefusesImpossibleSteps) {
  const double inf = std::numeric_limits<double>::infinity(), nan = std::nan("");
  for (double dt : {0.0, -0.01, inf, nan, 2.0, 1e-17, 1e-300})
    EXPECT_THROW((void)step_count(0.0, 1.0, dt), InputError) << dt;
  EXPECT_THROW((void)step_count(0.0, 0.0, 0.1), InputError);
  EXPECT_THROW((void)step_count(0.0, nan, 0.1), InputError);
  EXPECT_THROW((void)step_count(1.0, 0.5, 0.1), InputError);
  EXPECT_THROW((void)step_count(1e9, 1e9 + 1.0, 1e-8), InputError);  // the clock cannot resolve it
}

TEST(StepCount, MessageNamesTheValueAndWhatWasExpected) {
  try {
    (void)step_count(0.0, 1.0, -0.01);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("dt = -0.01"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("expected"), std::string::npos);
  }
}

TEST(StepCount, DoesNotTurnRoundingIntoAStep) {
  EXPECT_EQ(step_count(0.0, 1.0, 0.1), 10);
  EXPECT_EQ(step_count(0.0, 0.3, 0.1), 3);
  EXPECT_EQ(step_count(0.0, 1.0, 1.0 / 3.0), 3);
  EXPECT_EQ(step_count(0.0, 1.0, 0.3), 4);
}

TEST(Simulate, CountsTimeWithoutSummationDrift) {
  const Model model = make_model("oscillator");
  Integrator integrator = make_integrator("leapfrog", model.system);
  State state = model.state;
  History history;
  const double dt = 1e-4;
  std::int64_t n = 0;
  const RunResult result =
      simulate(model.system, integrator, state, history,
               {.dt = dt, .end_time = 1.0, .observer = [&](const State& at, const History&) {
                  ++n;
                  EXPECT_EQ(at.t, n == 10000 ? 1.0 : static_cast<double>(n) * dt);
                  return true;
                }});
  EXPECT_EQ(result.steps, 10000);
}

TEST(Simulate, ReportsBlowUpAsDivergedSoonAfterItHappens) {
  const Model model = make_model("S2(6)");
  Integrator integrator = make_integrator("leapfrog", model.system);
  State state = model.state;
  History history;
  const RunResult result = simulate(model.system, integrator, state, history, {.dt = 1e-3, .end_time = 10.0});
  EXPECT_TRUE(result.status.code == StatusCode::kDiverged || result.status.code == StatusCode::kNonFinite);
  EXPECT_FALSE(result.status.reason.empty());
  EXPECT_LT(result.steps, 200);
}

TEST(Simulate, StopsWhenTheObserverSaysSo) {
  const Model model = make_model("oscillator");
  Integrator integrator = make_integrator("rk4", model.system);
  State state = model.state;
  History history;
  int calls = 0;
  const RunResult result = simulate(
      model.system, integrator, state, history,
      {.dt = 0.001, .end_time = 1.0, .observer = [&](const State&, const History&) { return ++calls < 5; }});
  EXPECT_EQ(result.status.code, StatusCode::kInterrupted);
  EXPECT_EQ(result.steps, 5);
}

TEST(StepDoubling, EstimateIsWithinTenPercentOfTheTrueLocalError) {
  const Model model = make_model("oscillator");
  const double omega = std::sqrt(model.system.distance.spring[0] * model.system.inverse_mass.maxCoeff());
  for (const char* name : {"explicit_euler", "rk4"}) {
    Integrator integrator = make_integrator(name, model.system);
    const double dt = (std::string(name) == "rk4" ? 0.05 : 0.02) / omega;
    auto advance = [&](double step, State& at) {
      History history;
      ASSERT_TRUE(std::visit([&](auto& i) { return i.step(step, at, history, nullptr); }, integrator).ok());
    };
    // start away from a turning point, where the leading error term would vanish
    const State start = model.exact(0.3 / omega);
    State full = start, halves = start;
    advance(dt, full), advance(0.5 * dt, halves), advance(0.5 * dt, halves);
    const State truth = model.exact(0.3 / omega + dt);
    const int order = info(integrator).order;
    const double estimate = doubling_error(model.system, full, halves, dt, order);
    const double error = doubling_error(model.system, truth, halves, dt, 1);  // 2^1 - 1 = 1: the plain norm
    ASSERT_GT(error, 1e-14);
    EXPECT_NEAR(estimate / error, 1.0, 0.1) << name;
  }
}

TEST(StepDoubling, ErrorIsProportionalToTheToleranceOverSixDecades) {
  const Model model = make_model("spring_pendulum");
  Integrator judge = make_integrator("rk4", model.system);
  State exact = model.state;
  History past;
  const double end = 0.2 * model.end_time;
  ASSERT_TRUE(
      simulate(model.system, judge, exact, past, {.dt = end / 200000.0, .end_time = end}).status.ok());
  for (const char* name : {"leapfrog", "rk4"}) {
    double first = 0.0, last = 0.0;
    for (double tolerance : {1e-4, 1e-10}) {
      Integrator integrator = make_integrator(name, model.system);
      State state = model.state;
      History history;
      const AdaptiveResult result =
          simulate_adaptive(model.system, integrator, state, history,
                            {.tolerance = tolerance, .first_dt = 1e-4, .end_time = end});
      ASSERT_TRUE(result.status.ok()) << result.status.reason;
      EXPECT_EQ(state.t, end);
      (tolerance > 1e-6 ? first : last) = (state.q - exact.q).norm();
    }
    EXPECT_NEAR(std::log10(first / last) / 6.0, 1.0, 0.15) << name << " " << first << " " << last;
  }
}

TEST(StepDoubling, RefusesToExtrapolateAcrossRods) {
  const Model model = make_model("S1h(3)");
  Integrator integrator = make_integrator("implicit_euler_newton", model.system);
  State state = model.state;
  History history;
  AdaptiveOptions options{.tolerance = 1e-5, .first_dt = 1e-3, .end_time = 0.05};
  EXPECT_EQ(simulate_adaptive(model.system, integrator, state, history, options).status.code,
            StatusCode::kRefused);
  options.extrapolate = false;
  EXPECT_TRUE(simulate_adaptive(model.system, integrator, state, history, options).status.ok());
}

TEST(StepDoubling, GivesUpAtTheSmallestStepWithAReason) {
  const Model model = make_model("S2(6)");
  Integrator integrator = make_integrator("explicit_euler", model.system);
  State state = model.state;
  History history;
  const AdaptiveResult result =
      simulate_adaptive(model.system, integrator, state, history,
                        {.tolerance = 1e-14, .first_dt = 1e-3, .least_dt = 1e-5, .end_time = 1.0});
  EXPECT_EQ(result.status.code, StatusCode::kStepTooSmall);
  EXPECT_NE(result.status.reason.find("dt"), std::string::npos);
}

TEST(EqualStep, FillsTheIntervalAndIsNeverLonger) {
  Random random(3);
  for (int i = 0; i < 20000; ++i) {
    const double dt = std::pow(10.0, random.uniform(-6, 0));
    const double t0 = i % 2 ? 0.0 : random.uniform(0, 1e3),
                 end = t0 + dt * std::pow(10.0, random.uniform(-2, 4));
    const double step = equal_step(t0, end, dt), steps = static_cast<double>(step_count(t0, end, step));
    ASSERT_LE(step, dt);
    ASSERT_NEAR(steps * step, end - t0, 1e-8 * step + 1e-12) << t0 << " " << end << " " << dt;
    ASSERT_LT(steps - 1, (end - t0) / dt) << "one step fewer would do";
  }
}

TEST(EqualStep, IsTheStepItselfWhereItDividesHoweverLateInTheRun) {
  for (double dt : {0.01, 1e-3, 1e-6, 0.3e-4})
    for (int count : {1, 3, 10, 1000})
      for (double k : {0.0, 1.0, 7.0, 1e3, 1e6 + 1, 3e8}) {
        const double interval = count * dt, t0 = k * interval, end = (k + 1) * interval;
        if (!(dt > 1e4 * 2.3e-16 * end)) continue;
        EXPECT_EQ(equal_step(t0, end, dt), std::min(dt, end - t0)) << dt << " " << count << " " << k;
        EXPECT_EQ(step_count(t0, end, dt > end - t0 ? end - t0 : dt), count)
            << dt << " " << count << " " << k;
      }
}

TEST(Simulate, EndsBeforeTheFirstStepThatAMotionHasNoValueFor) {
  SystemBuilder builder;
  const Anchor mass = builder.add_particle(1.0, {1, 0, 0});
  const Motion motion{[](double t) { return Vector3d(t < 0.35 ? 0.0 : std::nan(""), 0, 0); },
                      [](double) { return Vector3d(0, 0, 0); }, [](double) { return Vector3d(0, 0, 0); }};
  builder.add_distance(builder.add_moving_point(motion), mass, {10.0}, 1.0);
  const auto built = builder.build();
  Integrator integrator = make_integrator("implicit_euler_notes", built.system);
  State state = built.state;
  History history;
  const RunResult result = simulate(built.system, integrator, state, history, {.dt = 0.1, .end_time = 1.0});
  EXPECT_EQ(result.status.code, StatusCode::kNonFinite);
  EXPECT_NE(result.status.reason.find("t = 0.4 s"), std::string::npos) << result.status.reason;
  EXPECT_EQ(result.steps, 3);
  EXPECT_TRUE(state.q.allFinite());
}

}  // namespace
}  // namespace feder
