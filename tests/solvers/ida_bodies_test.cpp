// The judge with rigid bodies and hard rows: the form of Gear, Gupta and Leimkuhler.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "engine/energy.h"
#include "engine/joints.h"
#include "models/catalog.h"
#include "solvers/ida_reference.h"
#include "solvers/reference.h"
#include "solvers/simulate.h"
#include "tests/solvers/ida_jacobian.h"
#include "tests/solvers/random_mechanism.h"

namespace feder {
namespace {

/// Three bodies on joints, hard or of 300 N/m, and springs, all moving.
SystemBuilder::Built joined(unsigned seed, double hard_share) {
  return test::random_mechanism(seed, 3, hard_share, 300.0);
}

TEST(IdaBodies, JacobianAgreesWithFiniteDifferences) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    auto error = [&](double hard_share, IdaForm form) {
      const auto [s, state] = joined(seed, hard_share);
      return test::jacobian_error(s, state, form);
    };
    EXPECT_LT(error(0.0, IdaForm::kOde), 1e-9) << seed;         // 1.5e-12
    EXPECT_LT(error(0.0, IdaForm::kCompliance), 1e-9) << seed;  // 4.6e-12
    EXPECT_LT(error(1.0, IdaForm::kGgl), 1e-9) << seed;         // 1.8e-12
  }
}

TEST(IdaBodies, InitialValuesSatisfyTheEquations) {
  for (const auto& [share, form] :
       {std::pair{0.0, IdaForm::kOde}, std::pair{0.0, IdaForm::kCompliance}, std::pair{1.0, IdaForm::kGgl}}) {
    const auto [s, state] = joined(5, share);
    IdaSystem system(s, state, form);
    VectorXd y(system.unknowns()), y_prime(system.unknowns()), r(system.unknowns());
    ASSERT_TRUE(system.initial(state, y.data(), y_prime.data()).ok());
    ASSERT_GT(y_prime.norm(), 1.0);
    ASSERT_TRUE(system.residual(state.t, y.data(), y_prime.data(), r.data()).ok());
    EXPECT_LT(r.cwiseAbs().maxCoeff(), 1e-12);  // 5.3e-15
  }
}

State rk4(const System& s, const State& start, double dt, double end) {
  Integrator integrator = make_integrator("rk4", s);
  State state = start;
  History history;
  EXPECT_TRUE(simulate(s, integrator, state, history, {.dt = dt, .end_time = end}).status.ok());
  return state;
}

TEST(IdaBodies, AgreesWithRk4OnMechanismsWithJointsAndSprings) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const auto [s, start] = test::random_mechanism(seed, 4, 1.0, 0.0);
    const IdaResult judge = ida_solve(s, start, 0.5);
    ASSERT_TRUE(judge.status.ok()) << judge.status.reason;
    EXPECT_EQ(judge.form, "ggl");
    const double error = position_error(s, judge.state, rk4(s, start, 2e-4, 0.5));
    EXPECT_LT(error, 2e-7) << seed;                                                   // 3.9e-8
    EXPECT_NEAR(total_energy(s, judge.state), total_energy(s, start), 1e-5) << seed;  // 5.3e-6
    std::printf("ggl %u: %ld steps, against rk4 %.2g m\n", seed, judge.steps, error);
  }
}

TEST(IdaBodies, TwoTolerancesBracketTheErrorOnTheRodPendulum) {
  const Model model = make_model("pendulum");
  ASSERT_TRUE(model.system.has_hard_rows);
  const double end = 2.0;
  ReferenceOptions options;
  options.use_cache = false;
  const Reference judge = make_reference(model.system, model.state, end, options);
  ASSERT_TRUE(judge.status.ok()) << judge.status.reason;
  EXPECT_NE(judge.method.find("ggl"), std::string::npos) << judge.method;
  EXPECT_LT(judge.error, 1e-6);                                                         // 5.7e-8
  EXPECT_LT(position_error(model.system, judge.state, model.exact(end)), judge.error);  // 4.5e-10
}

TEST(IdaBodies, FollowsAFreeTop) {
  const Model model = make_model("asymmetric_top");
  const IdaResult judge = ida_solve(model.system, model.state, 3.0);
  ASSERT_TRUE(judge.status.ok()) << judge.status.reason;
  EXPECT_LT(position_error(model.system, judge.state, rk4(model.system, model.state, 1e-4, 3.0)),
            2e-7);  // 1.2e-8
}

TEST(IdaBodies, RefusesRedundantAndOpenRowsByName) {
  SystemBuilder builder;
  const Anchor door = builder.add_body(solid_box("door", 1.0, {0.5, 0.3, 0.1}), {});
  for (double z : {0.0, 0.2}) add_hinge(builder, {}, door, {0.0, 0.0, z}, Vector3d::UnitZ());
  const auto [s, start] = builder.build();
  const IdaResult redundant = ida_solve(s, start, 0.1);
  EXPECT_EQ(redundant.status.code, StatusCode::kRefused);
  EXPECT_NE(redundant.status.reason.find("depends on other hard rows"), std::string::npos)
      << redundant.status.reason;

  Model open = make_model("pendulum");
  open.state.q[3] += 0.1;
  const IdaResult refused = ida_solve(open.system, open.state, 0.1);
  EXPECT_EQ(refused.status.code, StatusCode::kRefused);
  EXPECT_NE(refused.status.reason.find("starts open"), std::string::npos) << refused.status.reason;
}

}  // namespace
}  // namespace feder
