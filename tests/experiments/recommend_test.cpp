// The rules of recommend(): which method, and runs at the step it gives.
#include "experiments/support/recommend.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "engine/energy.h"
#include "experiments/support/measure.h"
#include "models/catalog.h"
#include "solvers/reference.h"
#include "solvers/simulate.h"

namespace feder::experiments {
namespace {

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

Explanation explain_spec(const std::string& spec) {
  return explain(make_model(spec));
}

TEST(Recommend, FollowsItsRules) {
  const auto integrator = [](const std::string& spec) { return explain_spec(spec).recommended.integrator; };
  EXPECT_EQ(integrator("S3b(30,10)"), "implicit_euler_newton");  // 250 dependent rows
  EXPECT_EQ(integrator("four_bar"), "rk4");                      // 3 of them
  EXPECT_EQ(integrator("S2(20)"), "leapfrog");
  EXPECT_EQ(integrator("S2(20):damping_time=1e-6"), "rk4");
  EXPECT_EQ(integrator("S2(8)"), "leapfrog");
  EXPECT_EQ(integrator("S4(10)"), "leapfrog");
  EXPECT_EQ(integrator("oscillator"), "rk4");  // its motion is that of its spring
  EXPECT_EQ(integrator("asymmetric_top"), "rk4");
  EXPECT_EQ(integrator("S2(20):damping_time=1"), "implicit_euler_newton");  // overdamped
}

TEST(Recommend, LeavesSpringsAloneThatAreFarTooFast) {
  Model model = make_model("S2(20)");
  EXPECT_EQ(explain(model).recommended.integrator, "leapfrog");
  model.end_time *= 1e3;
  const Recommendation r = explain(model).recommended;
  EXPECT_EQ(r.integrator, "implicit_euler_newton");
  EXPECT_TRUE(contains(r.why, "leapfrog would need")) << r.why;
}

TEST(Recommend, RunsEndWellAtItsStep) {
  for (const char* spec : {"oscillator",
                           "damped_oscillator",
                           "pendulum",
                           "spring_pendulum",
                           "chain",
                           "hanging_chain:n=20",
                           "taut_string",
                           "bending_rod",
                           "S2(8)",
                           "S4(5)",
                           "asymmetric_top",
                           "S3c(20)",
                           "S3b(6,3)",
                           "S1h(10)",
                           "plate_net:n=4",
                           "heavy_top",
                           "double_pendulum",
                           "double_pendulum:stiffness=1e6",
                           "n_pendulum:n=6",
                           "four_bar",
                           "slider_crank",
                           "flexible_linkage",
                           "S2(8):damping_time=1e-2"}) {
    const Model model = make_model(spec);
    const Recommendation r = explain(model).recommended;
    Integrator integrator = make_integrator(r.integrator, model.system);
    State state = model.state;
    History history;
    const double end = std::min(model.end_time, 300 * r.dt);
    const Status status =
        simulate(model.system, integrator, state, history, {.dt = r.dt, .end_time = end}).status;
    EXPECT_TRUE(status.ok()) << spec << " " << r.integrator << ": " << status.reason;
    const double gain = total_energy(model.system, state) - total_energy(model.system, model.state);
    // measured 7e-7 at most (four_bar)
    EXPECT_LE(gain, 1e-5 * energy_scale(model)) << spec << " " << r.integrator;
  }
}

// Rules 1 and 6: a net with 250 dependent rows, and springs a thousand times faster than the fall.
TEST(Recommend, RunsEndWellAtItsStepWhereItIsImplicit) {
  for (const auto& [spec, factor] : {std::pair{"S3b(30,10)", 1.0}, std::pair{"S2(8)", 1e4}}) {
    Model model = make_model(spec);
    model.end_time *= factor;
    const Recommendation r = explain(model).recommended;
    ASSERT_EQ(r.integrator, "implicit_euler_newton") << spec;
    Integrator integrator = make_integrator(r.integrator, model.system);
    State state = model.state;
    History history;
    const Status status =
        simulate(model.system, integrator, state, history, {.dt = r.dt, .end_time = 8 * r.dt}).status;
    EXPECT_TRUE(status.ok()) << spec << ": " << status.reason;
    EXPECT_LT(total_energy(model.system, state), total_energy(model.system, model.state)) << spec;
  }
}

TEST(Recommend, ReachesTheAccuracyItPromisesOnMechanisms) {
  for (const char* spec : {"double_pendulum", "four_bar", "slider_crank", "n_pendulum:n=6"}) {
    const Model model = make_model(spec);
    const Recommendation r = explain(model).recommended;
    ASSERT_EQ(r.integrator, "rk4");
    State states[2] = {model.state, model.state};
    for (int i = 0; i < 2; ++i) {
      Integrator integrator = make_integrator("rk4", model.system);
      History history;
      const RunOptions run{.dt = i == 0 ? r.dt : 0.25 * r.dt, .end_time = model.end_time};
      ASSERT_TRUE(simulate(model.system, integrator, states[i], history, run).status.ok());
    }
    // measured 2e-7 ... 2.9e-6
    EXPECT_LE(position_error(model.system, states[0], states[1]), 1e-5 * model.scene_length) << spec;
  }
}

TEST(Recommend, HasNothingToSayWhereNothingMoves) {
  SystemBuilder builder;
  builder.add_particle(1.0, {0, 0, 0}, {0, 0, 0}, kPinned);
  auto [system, state] = builder.build();
  const Explanation e =
      explain({.name = "still", .system = system, .state = state, .end_time = 1.0, .scene_length = 1.0});
  EXPECT_EQ(e.unknowns, 0);
  EXPECT_TRUE(e.recommended.integrator.empty());
  EXPECT_TRUE(contains(to_text(e), "Nothing can move"));
}

}  // namespace
}  // namespace feder::experiments
