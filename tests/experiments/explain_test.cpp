// What explain() says, against closed forms, against the code that it predicts, and against runs.
#include "experiments/support/explain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <set>

#include "engine/check.h"
#include "models/catalog.h"
#include "models/chain.h"
#include "models/oscillator.h"
#include "solvers/reference.h"
#include "solvers/simulate.h"

namespace feder::experiments {
namespace {

const MethodOutlook& method(const Explanation& e, const std::string& name) {
  return *std::find_if(e.methods.begin(), e.methods.end(),
                       [&](const MethodOutlook& m) { return m.name == name; });
}

const RouteOutlook& route(const Explanation& e, const std::string& name) {
  return *std::find_if(e.routes.begin(), e.routes.end(),
                       [&](const RouteOutlook& r) { return r.name == name; });
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

Explanation explain_spec(const std::string& spec, double dt = 0.0) {
  return explain(make_model(spec), dt);
}

// ---- Frequencies and limits

TEST(Explain, KnowsTheFrequencyOfAnOscillator) {
  const Explanation e = explain(make_oscillator({.mass = 2.0, .stiffness = 50.0, .amplitude = 0.1}));
  EXPECT_NEAR(e.largest_frequency, 5.0, 1e-12);
  // across the spring its tension k A pulls at the length 1 + A
  EXPECT_NEAR(e.smallest_frequency, std::sqrt(50.0 * 0.1 / 1.1 / 2.0), 1e-12);
  EXPECT_NEAR(method(e, "leapfrog").limit, 2.0 / 5.0, 1e-12);
  EXPECT_NEAR(method(e, "rk4").limit, 2.0 * std::numbers::sqrt2 / 5.0, 1e-12);
  EXPECT_EQ(method(e, "explicit_euler").limit, 0.0);
  EXPECT_TRUE(std::isinf(method(e, "implicit_euler_newton").limit));
}

TEST(Explain, KnowsFastestAndSlowestModeOfAChain) {
  const Chain options{.n = 10};
  const Explanation e = explain(make_chain(options));
  const double fast = chain_frequency(options, 10), slow = chain_frequency(options, 1);
  EXPECT_NEAR(e.largest_frequency, fast, 1e-12 * fast);
  EXPECT_NEAR(e.smallest_frequency, slow, 1e-11 * fast);
  EXPECT_NEAR(e.stiffness_ratio, fast / slow, 1e-9);
  EXPECT_NEAR(e.fastest_periods, fast * e.end_time / (2.0 * std::numbers::pi), 1e-9);
}

TEST(Explain, KnowsTheFastestModeOfLongChains) {
  for (const auto& [n, told] : {std::pair{1000, 1e-6}, std::pair{5000, 1e-3}}) {
    const Chain options{.n = n};
    const double fast = chain_frequency(options, n);
    const Explanation e = explain(make_chain(options));
    EXPECT_EQ(e.frequency_accuracy, told);
    EXPECT_NEAR(e.largest_frequency, fast, told * fast);
    EXPECT_TRUE(std::isnan(e.smallest_frequency));
  }
}

TEST(Explain, KnowsTheDampingRateOfADampedOscillator) {
  const Explanation e = explain_spec("damped_oscillator:mass=2,stiffness=50,damping_time=0.04,drag=3");
  EXPECT_NEAR(e.largest_damping_rate, (50.0 * 0.04 + 3.0) / 2.0, 1e-12);
  EXPECT_EQ(e.all_rows.damped, 1);
  EXPECT_EQ(explain_spec("oscillator").largest_damping_rate, 0.0);
}

TEST(Explain, KnowsHowFastTheStartIs) {
  EXPECT_NEAR(explain_spec("oscillator").excited_frequency, 10.0, 1e-11);
  EXPECT_EQ(explain_spec("oscillator:amplitude=0").excited_frequency, 0.0);
  // one mode alone: acceleration along it
  const Chain options{.n = 10, .modes = {{4, 1e-3}}};
  const double exact = chain_frequency(options, 4);
  EXPECT_NEAR(explain(make_chain(options)).excited_frequency, exact, 1e-9 * exact);
}

TEST(Explain, BoundsTheFrequenciesBesideHardRows) {
  const Explanation e = explain_spec("double_pendulum:stiffness=1e6");
  EXPECT_FALSE(e.spectrum_left_out.empty());
  EXPECT_GT(e.largest_frequency, 1000.0);  // sqrt(1e6 N/m / 1 kg), and more by the lever arms
  EXPECT_TRUE(std::isnan(e.smallest_frequency));
  EXPECT_EQ(explain_spec("double_pendulum").largest_frequency, 0.0);
}

TEST(Explain, CountsTheStepsAtTheLimit) {
  const Explanation e = explain_spec("chain");
  const MethodOutlook& leapfrog = method(e, "leapfrog");
  EXPECT_EQ(leapfrog.steps, static_cast<double>(step_count(0.0, e.end_time, leapfrog.limit)));
  EXPECT_EQ(method(e, "implicit_euler_newton").steps, 1.0);
  EXPECT_TRUE(std::isinf(method(e, "explicit_euler").steps));
}

TEST(Explain, JudgesTheStepSomebodyAsksAbout) {
  const double limit = method(explain_spec("chain"), "leapfrog").limit;
  EXPECT_EQ(method(explain_spec("chain", 0.99 * limit), "leapfrog").dt_asked, "stable");
  EXPECT_EQ(method(explain_spec("chain", 1.01 * limit), "leapfrog").dt_asked, "unstable");
  EXPECT_EQ(method(explain_spec("pendulum", 1e-3), "leapfrog").dt_asked, "unknown");
  EXPECT_EQ(method(explain_spec("pendulum", 1e-3), "explicit_euler").dt_asked, "refused");
  EXPECT_EQ(method(explain_spec("chain"), "leapfrog").dt_asked, "");
}

TEST(Explain, RefusesAStepThatIsNone) {
  EXPECT_THROW(explain_spec("chain", -1e-3), InputError);
  EXPECT_THROW(explain_spec("chain", std::nan("")), InputError);
  EXPECT_THROW(explain_spec("chain", INFINITY), InputError);
}

// ---- Rows

TEST(Explain, CountsNodesAndRowsByKind) {
  const Explanation cloth = explain_spec("S2(20)");
  EXPECT_EQ(cloth.particles, 400);
  EXPECT_EQ(cloth.unknowns, 3 * 400 - 6);  // two corners are held
  const int shortest = 2 * 20 * 19, diagonal = 2 * 19 * 19, bending = 2 * 20 * 18;
  EXPECT_EQ(cloth.all_rows.finite, shortest + diagonal + bending);
  EXPECT_EQ(cloth.all_rows.hard, 0);
  const Explanation bars = explain_spec("flexible_linkage");
  EXPECT_EQ(bars.bodies, 8);
  EXPECT_EQ(bars.all_rows.hard, 20);
  EXPECT_EQ(bars.all_rows.damped, 30);  // five welds of six rows
  EXPECT_EQ(bars.all_rows.finite, 31);  // and the spring
  EXPECT_EQ(explain_spec("slider_crank:drive=motor").driven, 1);
}

TEST(Explain, CountsTheNonzerosOfTheMatrix) {
  // 10 masses, 11 springs, of which 9 hold two of them
  EXPECT_EQ(explain_spec("chain:n=10").matrix_nonzeros, 10 + 11 + 2 * (9 * 2 + 2));
}

TEST(Explain, NamesTheThreeDependentRowsOfAFourBar) {
  const Explanation e = explain_spec("four_bar");
  EXPECT_EQ(e.rank, 17);
  EXPECT_EQ(e.dependent, 3);
  EXPECT_EQ(std::set<std::string>(e.dependent_rows.begin(), e.dependent_rows.end()).size(), 3u);
  for (const std::string& name : e.dependent_rows) EXPECT_TRUE(contains(name, "body")) << name;
  EXPECT_TRUE(contains(e.index, "refuses dependent rows"));
}

TEST(Explain, NamesAtMostFiveDependentRows) {
  const Explanation e = explain_spec("S3b(6,3)");
  EXPECT_EQ(e.dependent, 9);
  EXPECT_EQ(e.dependent_rows.size(), 5u);
}

TEST(Explain, KnowsTheFreedomOfMechanisms) {
  EXPECT_EQ(explain_spec("four_bar").degrees_of_freedom, 1);
  EXPECT_EQ(explain_spec("double_pendulum").degrees_of_freedom, 2);
  EXPECT_EQ(explain_spec("slider_crank").degrees_of_freedom, 1);
  EXPECT_EQ(explain_spec("heavy_top").degrees_of_freedom, 3);
  EXPECT_EQ(explain_spec("n_pendulum:n=7").degrees_of_freedom, 7);
  EXPECT_EQ(explain_spec("pendulum").degrees_of_freedom, 1);
}

TEST(Explain, MeasuresHowFarTheStartIsOffItsRows) {
  Model model = make_model("pendulum");
  const Explanation closed = explain(model);
  EXPECT_LE(closed.gap, 1e-15);  // 1.1e-16
  const Vector3d rod = model.state.q.segment<3>(3) - model.state.q.segment<3>(0);
  const int moving = 3 * (model.system.mass[0] > 0.0 ? 0 : 1);
  const Vector3d out = (moving == 3 ? 1.0 : -1.0) * rod.normalized();
  model.state.q.segment<3>(moving) += 1e-3 * out;
  model.state.v.segment<3>(moving) += 0.5 * out;
  const Explanation open = explain(model);
  EXPECT_NEAR(open.gap, 1e-3, 1e-12);
  EXPECT_NEAR(open.velocity_gap, 0.5, 1e-12);
}

TEST(Explain, PredictsNothingForARod) {
  const Explanation e = explain_spec("pendulum");
  EXPECT_EQ(e.index[0], '3');
  EXPECT_TRUE(std::isnan(method(e, "leapfrog").limit));
  EXPECT_TRUE(std::isnan(method(e, "rk4").limit));
  EXPECT_FALSE(method(e, "explicit_euler").refusal.empty());
  EXPECT_TRUE(contains(to_text(e), "not predicted"));
  EXPECT_EQ(explain_spec("oscillator").index[0], '0');
}

TEST(Explain, KnowsHowFastBodiesTurn) {
  EXPECT_NEAR(explain_spec("heavy_top:spin=70").turning_rate, 70.0, 1e-9);
  EXPECT_NEAR(explain_spec("asymmetric_top").turning_rate, 10.0, 1e-12);
  EXPECT_NEAR(explain_spec("pendulum:length=2").swing_rate, std::sqrt(9.81 / 2.0), 1e-12);
}

// ---- Routes and judge

TEST(Explain, TellsWhatAutoTakes) {
  const Explanation cloth = explain_spec("S2(20)");
  EXPECT_TRUE(cloth.auto_reason.starts_with("primal"));
  EXPECT_GT(route(cloth, "primal").flops, 1e6);
  EXPECT_FALSE(route(cloth, "dense").refusal.empty());
  EXPECT_TRUE(std::isnan(route(cloth, "dual").flops_geometric));
  EXPECT_TRUE(explain_spec("S3c(20)").auto_reason.starts_with("dual_blocks"));
  EXPECT_TRUE(explain_spec("four_bar").auto_reason_geometric.starts_with("kkt"));
}

TEST(Explain, TellsWhichJudgeWillRun) {
  const auto expect = [](const std::string& spec, double end, const std::string& done,
                         const std::string& told) {
    Model model = make_model(spec);
    model.end_time = end;
    ReferenceOptions options;
    options.use_cache = false;
    options.halving_seconds = 0.2;
    const std::string method = make_reference(model.system, model.state, end, options).method;
    const std::string judge = explain(model).judge;
    EXPECT_TRUE(method.starts_with(done)) << spec << ": " << method;
    EXPECT_TRUE(judge.starts_with(told)) << spec << ": " << judge;
  };
  expect("oscillator", 2e-3, "ida ode", "IDA at two tolerances, ode");
  expect("oscillator:stiffness=1e10,amplitude=0", 0.3, "ida compliance", "IDA at two tolerances, compliance");
  expect("pendulum", 2e-3, "ida ggl", "IDA at two tolerances, ggl");
  expect("four_bar", 2e-3, "rk4", "rk4, steps halved");
  expect("asymmetric_top", 2e-3, "ida ode", "IDA at two tolerances, ode");
  expect("S2(25)", 2e-3, "leapfrog", "leapfrog at dt and dt/2");
  expect("S2(25):damping_time=1e-6", 2e-3, "rk4", "rk4 at dt and dt/2");
}

// ---- Predicted limits against runs

// Largest growth of a tiny displacement over 400 steps, against the same run without it; infinite where a
// step fails.
double growth(const Model& model, const std::string& name, double dt) {
  std::vector<Integrator> twins;
  for (int i = 0; i < 2; ++i) twins.push_back(make_integrator(name, model.system));
  State states[2] = {model.state, model.state};
  History histories[2];
  std::mt19937_64 random(7);
  for (int i = 0; i < 3 * model.system.places(); ++i)
    if (model.system.inverse_mass[i] > 0.0)
      states[1].q[i] += 1e-9 * model.scene_length * (static_cast<double>(random() >> 11) * 0x1p-52 - 1.0);
  const double start = (states[1].q - states[0].q).norm();
  double most = 1.0;
  for (Integrator& twin : twins)
    if (!std::visit([](auto& i) { return i.prepare(); }, twin).ok()) return INFINITY;
  for (int step = 0; step < 400; ++step) {
    for (int i = 0; i < 2; ++i) {
      const Status status = std::visit(
          [&](auto& method) { return method.step(dt, states[i], histories[i], nullptr); }, twins[i]);
      if (!status.ok()) return INFINITY;
    }
    const double now = (states[1].q - states[0].q).norm() / start;
    if (!(now <= most)) most = now;
  }
  return std::isnan(most) ? INFINITY : most;
}

TEST(Explain, LimitsAreWhereUndampedScenesBlowUp) {
  for (const char* spec : {"oscillator", "chain", "hanging_chain:n=20", "taut_string", "S4(4)", "S2(6)",
                           "bending_rod", "plate_net:n=3"}) {
    const Model model = make_model(spec);
    const Explanation e = explain(model);
    for (const char* name : {"leapfrog", "rk4"}) {
      const double limit = method(e, name).limit;
      // measured at most 9.3 and at least 2e8
      EXPECT_LE(growth(model, name, 0.9 * limit), 100.0) << spec << " " << name;
      EXPECT_GE(growth(model, name, 1.1 * limit), 1e6) << spec << " " << name;
    }
  }
}

// ---- What is skipped is said; what is said can be read

TEST(Explain, SaysThatARankIsNotComputed) {
  const Explanation e = explain_spec("S1h(40001)");
  EXPECT_EQ(e.rank, -1);
  EXPECT_EQ(e.degrees_of_freedom, -1);
  EXPECT_TRUE(contains(to_text(e), "not computed above 40000 hard rows"));
  EXPECT_EQ(e.recommended.integrator, "implicit_euler_newton");
}

TEST(Explain, SaysThatRoutesAreNotAnalysed) {
  const Explanation e = explain_spec("S4(24)");
  EXPECT_TRUE(std::isnan(route(e, "primal").flops));
  EXPECT_TRUE(e.auto_reason.starts_with("primal"));
  EXPECT_TRUE(contains(to_text(e), "not analysed"));
}

TEST(Explain, SaysWhereADegenerateStartStopsIt) {
  Model model = make_model("oscillator");
  model.state.q.segment<3>(3) = model.state.q.segment<3>(0);
  const Explanation e = explain(model);
  EXPECT_TRUE(contains(e.not_linearised, "distance row 0")) << e.not_linearised;
  EXPECT_TRUE(std::isnan(e.largest_frequency));
  EXPECT_TRUE(contains(to_text(e), "cannot be linearised"));
}

TEST(Explain, FitsOnAPageForEveryModelOfTheCatalogue) {
  for (const ModelInfo& info : catalog()) {
    const std::string text = to_text(explain_spec(info.name, 1e-3));
    EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 42) << text;
    std::size_t begin = 0;
    for (std::size_t end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
      const std::string line = text.substr(begin, end - begin);
      EXPECT_LE(line.size(), 120u) << line;
      EXPECT_FALSE(line.ends_with(' ')) << line;
    }
  }
}

TEST(Explain, WritesJsonWithTheSameFigures) {
  const Explanation e = explain_spec("pendulum:stiffness=1e4", 1e-3);
  const auto j = nlohmann::json::parse(to_json(e));
  EXPECT_EQ(j["spectrum"]["largest_frequency_rad_s"].get<double>(), e.largest_frequency);
  EXPECT_EQ(j["integrators"][1]["stable_below_s"].get<double>(), method(e, "leapfrog").limit);
  EXPECT_EQ(j["integrators"][5]["stable_below_s"], "inf");
  EXPECT_EQ(j["recommended"]["dt_s"].get<double>(), e.recommended.dt);
  EXPECT_EQ(nlohmann::json::parse(to_json(explain_spec("pendulum")))["integrators"][1]["stable_below_s"],
            "nan");
}

}  // namespace
}  // namespace feder::experiments
