// Every route against the dense one, over size, stiffness, masks, row types and seeds; and what each must
// refuse or report.
#include <gtest/gtest.h>

#include <cmath>

#include "models/catalog.h"
#include "solvers/linear/linear_solver.h"
#include "tests/solvers/random_system.h"

namespace feder {
namespace {

using test::implicit_euler_kkt;
using test::random_system;
using test::RandomSystemOptions;

struct Solved {
  Status status;
  SolveReport report;
  VectorXd v, y;
};

Solved solve(const std::string& route, const System& system, Kkt kkt, SolveOptions options = {}) {
  Solved out;
  LinearSolver solver(route, options);
  out.status = solver.analyze(system, kkt.geometric);
  if (out.status.ok()) out.status = solver.factor(kkt);
  if (!out.status.ok()) return out;
  out.report = solver.solve(kkt, out.v, out.y);
  out.status = out.report.status;
  return out;
}

double difference(const VectorXd& a, const VectorXd& b) {
  return (a - b).norm() / b.norm();
}

template <class T>
class EveryRoute : public ::testing::Test {};
using SparseRoutes = ::testing::Types<KktLdlt, PrimalSchur, DualSchur>;
TYPED_TEST_SUITE(EveryRoute, SparseRoutes);

TYPED_TEST(EveryRoute, AgreesWithTheDenseSolveOnRandomSystems) {
  SolveOptions exact;
  exact.refine_above = 1e-16;
  for (unsigned seed = 0; seed < 12; ++seed)
    for (double stiffness : {1e1, 1e4, 1e7}) {
      const auto [system, state] = random_system(seed, {.particles = 4 + 2 * static_cast<int>(seed),
                                                        .stiffness = stiffness,
                                                        .damping_time = seed % 2 ? 0.01 : 0.0});
      Kkt kkt = implicit_euler_kkt(system, state, 0.01);
      const Solved sparse = solve(TypeParam::kName, system, kkt, exact),
                   dense = solve("dense", system, kkt, exact);
      ASSERT_TRUE(sparse.status.ok()) << sparse.status.reason;
      ASSERT_TRUE(dense.status.ok()) << dense.status.reason;
      ASSERT_GT(dense.v.norm(), 1e-3);
      EXPECT_LT(difference(sparse.v, dense.v), 1e-11)
          << "seed " << seed << " d " << stiffness;  // measured below 2e-13
      EXPECT_LT(sparse.report.backward_error, 1e-15);
    }
}

TYPED_TEST(EveryRoute, AgreesWithTheDenseSolveWithClampedGeometricStiffnessOrRefusesByName) {
  const auto [system, state] = random_system(3, {.particles = 20});
  Kkt kkt = implicit_euler_kkt(system, state, 0.05, GeometricStiffness::kClamped);
  VectorXd Kv = VectorXd::Zero(state.v.size());
  kkt.add_geometric(state.v, Kv);
  ASSERT_GT(Kv.norm(), 1e-3);
  const Solved sparse = solve(TypeParam::kName, system, kkt), dense = solve("dense", system, kkt);
  if constexpr (std::is_same_v<TypeParam, DualSchur>) {
    EXPECT_EQ(sparse.status.code, StatusCode::kRefused);
    EXPECT_NE(sparse.status.reason.find("dual route"), std::string::npos);
  } else {
    ASSERT_TRUE(sparse.status.ok()) << sparse.status.reason;
    EXPECT_LT(difference(sparse.v, dense.v), 1e-12);
  }
}

TYPED_TEST(EveryRoute, SolvesRodsExactlyOrRefusesThemByName) {
  const auto [system, state] = random_system(5, {.particles = 20, .rods = 6});
  ASSERT_TRUE(system.has_hard_rows);
  Kkt kkt = implicit_euler_kkt(system, state, 0.01);
  const Solved sparse = solve(TypeParam::kName, system, kkt), dense = solve("dense", system, kkt);
  if constexpr (std::is_same_v<TypeParam, PrimalSchur>) {
    EXPECT_EQ(sparse.status.code, StatusCode::kRefused);
    EXPECT_NE(sparse.status.reason.find("is rigid"), std::string::npos) << sparse.status.reason;
  } else {
    ASSERT_TRUE(sparse.status.ok()) << sparse.status.reason;
    EXPECT_LT(difference(sparse.v, dense.v), 1e-11);
    VectorXd Jv;
    kkt.multiply_jacobian(sparse.v, Jv);
    for (int k = 0; k < system.rows; ++k)
      if (std::isinf(system.stiffness[k])) {
        EXPECT_NEAR(Jv[k] + kkt.r[k], 0.0, 1e-11);
      }
  }
}

TYPED_TEST(EveryRoute, LeavesMaskedCoordinatesAtExactlyZero) {
  const auto [system, state] = random_system(1, {.particles = 20});
  const Solved sparse = solve(TypeParam::kName, system, implicit_euler_kkt(system, state, 0.01));
  ASSERT_FALSE(system.masked.empty());
  for (int i : system.masked) EXPECT_EQ(sparse.v[i], 0.0);
}

TYPED_TEST(EveryRoute, ReportsNonFiniteNumbersInsteadOfAnAnswer) {
  for (double poison : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    for (int where = 0; where < 4; ++where) {
      const auto [system, state] = random_system(2, {.particles = 15});
      Kkt kkt = implicit_euler_kkt(system, state, 0.01);
      const int free = 3 * 5;
      (where == 0 ? kkt.p[free] : where == 1 ? kkt.r[0] : where == 2 ? kkt.u[0] : kkt.mass[free]) = poison;
      if (where == 3) kkt.inverse_mass[free] = 1.0 / poison;
      EXPECT_FALSE(solve(TypeParam::kName, system, kkt).status.ok()) << poison << " in place " << where;
    }
}

TYPED_TEST(EveryRoute, HasInertiaOfAQuasidefiniteMatrix) {
  const auto [system, state] = random_system(8, {.particles = 18});
  Kkt kkt = implicit_euler_kkt(system, state, 0.01);
  const Solved sparse = solve(TypeParam::kName, system, kkt), dense = solve("dense", system, kkt);
  ASSERT_GT(system.active_rows, 10);
  EXPECT_EQ(dense.report.inertia.positive, system.free_count);
  EXPECT_EQ(dense.report.inertia.negative, system.active_rows);
  EXPECT_EQ(sparse.report.inertia.positive, system.free_count);
  EXPECT_EQ(sparse.report.inertia.negative, system.active_rows);
}

TYPED_TEST(EveryRoute, EstimatesTheConditionWhenAsked) {
  const auto [system, state] = random_system(8, {.particles = 18});
  SolveOptions options;
  EXPECT_EQ(solve(TypeParam::kName, system, implicit_euler_kkt(system, state, 0.01), options).report.rcond,
            -1.0);
  options.estimate_condition = true;
  const double rcond =
      solve(TypeParam::kName, system, implicit_euler_kkt(system, state, 0.01), options).report.rcond;
  EXPECT_GT(rcond, 0.0);
  EXPECT_LE(rcond, 1.0);
}

TYPED_TEST(EveryRoute, NeverAnswersAContradictionOfHardRows) {
  if constexpr (!std::is_same_v<TypeParam, PrimalSchur>)
    for (unsigned seed = 0; seed < 50; ++seed) {
      // a triangle of rods, one of them twice with another length: numbers that are not tidy
      std::mt19937 random(seed);
      std::uniform_real_distribution<double> unit(-1.0, 1.0);
      auto point = [&] { return Vector3d(unit(random), unit(random), unit(random)); };
      SystemBuilder builder;
      const Anchor a = builder.add_particle(1.0 + std::abs(unit(random)), point()),
                   b = builder.add_particle(0.3, point()), c = builder.add_particle(0.7, point());
      const Material rod{std::numeric_limits<double>::infinity(), 0.0};
      builder.add_distance(a, b, rod), builder.add_distance(b, c, rod), builder.add_distance(c, a, rod);
      builder.add_distance(a, b, rod, 1e-3 + 0.5 * std::abs(unit(random)));
      const auto [system, state] = builder.build();
      EXPECT_FALSE(solve(TypeParam::kName, system, implicit_euler_kkt(system, state, 0.01)).status.ok())
          << "seed " << seed;
    }
}

TEST(Routes, AgreeOnTheClothFromSoftToStiff) {
  SolveOptions exact;
  exact.refine_above = 1e-16;
  for (double stiffness : {1e2, 1e4, 1e6, 1e8, 1e10, 1e12}) {
    Model model = make_model("cloth:n=50,stiffness=" + std::to_string(stiffness) +
                             ",shear_stiffness=" + std::to_string(stiffness) +
                             ",bend_stiffness=" + std::to_string(0.1 * stiffness));
    for (int i = 0; i < model.state.v.size(); ++i)
      if (model.system.inverse_mass[i] > 0.0) {
        model.state.v[i] = 0.1 * std::cos(1.7 * i);
        model.state.q[i] += 1e-3 * std::sin(2.3 * i);
      }
    Kkt kkt = implicit_euler_kkt(model.system, model.state, 1.0 / 60.0);
    const Solved primal = solve("primal", model.system, kkt, exact);
    ASSERT_TRUE(primal.status.ok()) << primal.status.reason;
    ASSERT_GT(primal.v.norm(), 0.1);
    for (const char* route : {"kkt", "dual"}) {
      const Solved other = solve(route, model.system, kkt, exact);
      ASSERT_TRUE(other.status.ok()) << other.status.reason;
      EXPECT_LT(difference(other.v, primal.v), 1e-10)
          << route << " d " << stiffness;  // measured 5e-13 at 1e12
    }
  }
}

TEST(Routes, AgreeOnAChainOfRods) {
  Model model = make_model("S1h(200)");
  for (int i = 0; i < model.state.v.size(); ++i)
    if (model.system.inverse_mass[i] > 0.0) model.state.q[i] += 1e-3 * std::sin(2.3 * i);
  Kkt kkt = implicit_euler_kkt(model.system, model.state, 1e-3);
  const Solved direct = solve("kkt", model.system, kkt), dual = solve("dual", model.system, kkt);
  ASSERT_TRUE(direct.status.ok()) << direct.status.reason;
  ASSERT_TRUE(dual.status.ok()) << dual.status.reason;
  EXPECT_LT(difference(direct.v, dual.v), 1e-9);  // measured below 1e-13
  EXPECT_EQ(direct.report.inertia.negative, 200);
}

TEST(Routes, PrimalCertificateIsThatOfTheUnreducedSystem) {
  // at d = 1e12 the primal's own residual is tiny while v is not: without refinement the balance error must
  // tell
  Model model = make_model("cloth:n=20,stiffness=1e12,shear_stiffness=1e12,bend_stiffness=1e11");
  for (int i = 0; i < model.state.v.size(); ++i)
    if (model.system.inverse_mass[i] > 0.0) {
      model.state.v[i] = 0.1 * std::cos(1.7 * i);
      model.state.q[i] += 1e-3 * std::sin(2.3 * i);
    }
  Kkt kkt = implicit_euler_kkt(model.system, model.state, 1.0 / 60.0);
  SolveOptions once, exact;
  once.most_refinements = 0;
  once.accept_below = 1.0;
  exact.refine_above = 1e-16;
  const Solved first = solve("primal", model.system, kkt, once),
               refined = solve("primal", model.system, kkt, exact);
  ASSERT_GT(difference(first.v, refined.v), 1e-9);
  EXPECT_GT(first.report.balance_error, 1e-9);
  EXPECT_GT(refined.report.refinements, 0);
}

TEST(AutoRoute, TakesTheDualForChainsThePrimalForSheetsAndSaysWhy) {
  const Model chain = make_model("S1(100)"), cloth = make_model("S2(10)"), rods = make_model("S1h(50)");
  LinearSolver a, b, c, d, e;
  ASSERT_TRUE(a.analyze(chain.system, false).ok());
  ASSERT_TRUE(b.analyze(cloth.system, false).ok());
  ASSERT_TRUE(c.analyze(chain.system, true).ok());
  ASSERT_TRUE(d.analyze(rods.system, true).ok());
  ASSERT_TRUE(e.analyze(rods.system, false).ok());
  EXPECT_EQ(a.route_name(), "dual");
  EXPECT_EQ(b.route_name(), "primal");
  EXPECT_EQ(c.route_name(), "primal");  // geometric stiffness
  EXPECT_EQ(d.route_name(), "kkt");     // geometric stiffness and rods
  EXPECT_EQ(e.route_name(), "dual");
  EXPECT_NE(a.choice_reason().find("100 rows, 300 unknowns"), std::string::npos) << a.choice_reason();
  EXPECT_NE(d.choice_reason().find("is rigid"), std::string::npos) << d.choice_reason();
}

TEST(LinearSolver, RefusesAnUnknownRouteByName) {
  try {
    LinearSolver solver("cholesky");
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("cholesky"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("primal"), std::string::npos);
  }
}

}  // namespace
}  // namespace feder
