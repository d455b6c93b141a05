// Random searches: the claims of the other tests over thousands of random systems. 1 % runs with every test;
// all of it with `tests/run -L campaign`.
#include "tests/support/campaign.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "engine/kernels.h"
#include "models/catalog.h"
#include "solvers/simulate.h"
#include "tests/solvers/random_mechanism.h"
#include "tests/solvers/random_system.h"

namespace feder {
namespace {

using test::campaign_cases;
using test::random_system;
using test::RandomSystemOptions;

/// Sizes, stiffness, damping, rods and step of case number `seed`.
struct Draw {
  RandomSystemOptions system;
  double dt;
};

Draw draw(unsigned seed) {
  std::mt19937 random(seed + 1'000'000);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Draw d;
  d.system.particles = 3 + static_cast<int>(random() % 40);
  d.system.stiffness = std::pow(10.0, 8.0 * unit(random));
  d.system.damping_time = random() % 2 ? std::pow(10.0, -4.0 * unit(random)) : 0.0;
  d.system.rods = static_cast<int>(random() % 3) * static_cast<int>(random() % 6);
  d.system.bending = random() % 2;
  d.system.loops = random() % 2;
  d.dt = std::pow(10.0, -1.0 - 3.0 * unit(random));
  return d;
}

TEST(Campaign, RoutesThatAdmitASceneSolveItsStepMatrix) {
  int solved = 0, refused = 0, failed = 0;
  for (int seed = 0; seed < campaign_cases(20000); ++seed) {
    const Draw d = draw(seed);
    const auto [system, state] = random_system(seed, d.system);
    const GeometricStiffness kind = seed % 2 ? GeometricStiffness::kClamped : GeometricStiffness::kOff;
    Kkt kkt = test::implicit_euler_kkt(system, state, d.dt, kind);
    VectorXd dense_v;
    for (const char* route : {"dense", "kkt", "primal", "dual", "auto"}) {
      LinearSolver solver(route, {.refine_above = 1e-15});
      Status status = solver.analyze(system, kkt.geometric);
      if (status.code == StatusCode::kRefused) {
        ++refused;
        continue;
      }
      if (status.ok()) status = solver.factor(kkt);
      VectorXd v, y;
      if (status.ok()) status = solver.solve(kkt, v, y).status;
      if (!status.ok()) {  // at 1e8 N/m: it may fail, not lie
        ++failed;
        continue;
      }
      if (dense_v.size() == 0) dense_v = v;
      EXPECT_LT((v - dense_v).norm(), 1e-8 * dense_v.norm()) << "seed " << seed << " " << route;
      ++solved;
    }
  }
  EXPECT_GT(solved, 2 * refused);
  EXPECT_LE(failed, solved / 1000);  // 14 of 78000
}

TEST(Campaign, LedgersOfImplicitStepsClose) {
  int closed = 0, failed = 0;
  for (int seed = 0; seed < campaign_cases(5000); ++seed) {
    const Draw d = draw(seed);
    const auto [system, start] = random_system(seed, d.system);
    for (const IntegratorInfo& method : integrator_list()) {
      const std::string name = method.name;
      Integrator integrator = make_integrator(name, system);
      if (!info(integrator).implicit) continue;
      State state = start;
      History history;
      std::vector<EnergyLedger> ledgers;
      const RunResult run = simulate(system, integrator, state, history,
                                     {.dt = d.dt, .end_time = 3.5 * d.dt, .ledgers = &ledgers});
      if (!run.status.ok()) {  // edges collapse: it may fail, not lie
        ++failed;
        continue;
      }
      const double bound =
          1e-8;  // 4e-9, at stiffnesses up to 1e9 N/m; the tests of single scenes ask for 1e-12
      for (const EnergyLedger& ledger : ledgers) {
        EXPECT_LT(std::abs(ledger.imbalance()), bound * ledger.magnitude()) << "seed " << seed << " " << name;
        ++closed;
      }
    }
  }
  EXPECT_GT(closed, campaign_cases(5000) * 10);  // of 12 each
  EXPECT_LT(failed, campaign_cases(5000) / 5);   // nearly all Newton
}

TEST(Campaign, RoutesAgreeOnRandomMechanisms) {
  for (int seed = 0; seed < campaign_cases(5000); ++seed) {
    const auto [system, state] = test::random_mechanism(seed, 2 + seed % 15, 0.5, 1e4);
    Kkt kkt = test::implicit_euler_kkt(system, state, 0.01);
    VectorXd dense_v, v, y;
    for (const char* route : {"dense", "kkt", "dual", "auto"}) {
      LinearSolver solver(route);
      ASSERT_TRUE(solver.analyze(system, false).ok());
      ASSERT_TRUE(solver.factor(kkt).ok()) << "seed " << seed << " " << route;
      ASSERT_TRUE(solver.solve(kkt, v, y).status.ok()) << "seed " << seed << " " << route;
      if (dense_v.size() == 0) dense_v = v;
      EXPECT_LT((v - dense_v).norm(), 1e-9 * dense_v.norm()) << "seed " << seed << " " << route;
    }
  }
}

TEST(Campaign, HardJointsOfRandomMechanismsStayClosed) {
  int failed = 0;
  for (int seed = 0; seed < campaign_cases(1000); ++seed) {
    const auto [system, start] = test::random_mechanism(seed, 2 + seed % 10, 1.0, 0.0);
    for (const char* name : {"leapfrog", "implicit_euler_newton"}) {
      Integrator integrator = make_integrator(name, system);
      State state = start;
      History history;
      VectorXd phi;
      std::vector<EnergyLedger> ledgers;
      const RunResult run =
          simulate(system, integrator, state, history, {.dt = 2e-3, .end_time = 0.2, .ledgers = &ledgers});
      if (!run.status.ok()) {
        ++failed;
        continue;
      }
      evaluate_phi(system, state.q, phi);
      for (int k = 0; k < system.rows; ++k)
        if (std::isinf(system.stiffness[k]))
          EXPECT_NEAR(phi[k], 0.0, 1e-10) << "seed " << seed << " " << name;
      for (const EnergyLedger& ledger : ledgers)
        EXPECT_LT(std::abs(ledger.imbalance()), 1e-9 * ledger.magnitude()) << "seed " << seed << " " << name;
    }
  }
  EXPECT_LE(failed, campaign_cases(1000) / 50);
}

TEST(Campaign, JointsStayClosedOver1e5Steps) {
  const auto [system, start] = test::random_mechanism(4, 2, 1.0, 0.0);
  for (const char* name : {"leapfrog", "rk4"}) {
    Integrator integrator = make_integrator(name, system);
    State state = start;
    History history;
    double worst = 0.0, unit = 0.0;
    VectorXd phi;
    const int steps = campaign_cases(100000);
    const RunResult run =
        simulate(system, integrator, state, history,
                 {.dt = 1e-3, .end_time = 1e-3 * steps, .observer = [&](const State& at, const History&) {
                    evaluate_phi(system, at.q, phi);
                    for (int k = 0; k < system.rows; ++k)
                      if (std::isinf(system.stiffness[k])) worst = std::max(worst, std::abs(phi[k]));
                    for (const Body& b : system.bodies)
                      unit = std::max(unit, std::abs(at.q.segment<4>(b.quaternion).norm() - 1.0));
                    return true;
                  }});
    ASSERT_TRUE(run.status.ok()) << name << ": " << run.status.reason;
    EXPECT_LT(worst, 1e-10) << name;
    EXPECT_LT(unit, 1e-14) << name;
  }
}

TEST(Campaign, ABridgeOfPlatesHangsForTenSecondsAtFrameSteps) {
  const bool whole = campaign_cases(100) == 100;
  const Model model = make_model(whole ? "S3b(30,10)" : "S3b(6,3)");
  Integrator newton = make_integrator("implicit_euler_newton", model.system);
  State state = model.state;
  History history;
  VectorXd phi;
  double worst = 0.0;
  const RunResult run =
      simulate(model.system, newton, state, history,
               {.dt = 1.0 / 60.0, .end_time = 10.0, .observer = [&](const State& at, const History&) {
                  evaluate_phi(model.system, at.q, phi);
                  worst = std::max(worst, phi.cwiseAbs().maxCoeff());
                  return true;
                }});
  ASSERT_TRUE(run.status.ok()) << run.status.reason;
  EXPECT_LT(worst, 1e-6 * 0.2);  // of a link
  EXPECT_LT(total_energy(model.system, state), total_energy(model.system, model.state));
}

TEST(Campaign, VectorKernelsAgreeWithTheScalarOnes) {
  const std::string widest = kernels().name;
  for (int seed = 0; seed < campaign_cases(20000); ++seed) {
    const auto [system, state] = random_system(seed, draw(seed).system);
    VectorXd scalar, vector;
    ASSERT_TRUE(select_kernels("scalar"));
    ASSERT_TRUE(evaluate_forces(system, state, scalar).ok());
    ASSERT_TRUE(select_kernels(widest.c_str()));
    ASSERT_TRUE(evaluate_forces(system, state, vector).ok());
    EXPECT_LT((scalar - vector).norm(), 1e-14 * scalar.norm()) << "seed " << seed;
  }
}

}  // namespace
}  // namespace feder
