// Fluids whose density is a hard row: what the direct route and sweeps hold, keep and refuse.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>

#include "engine/energy.h"
#include "engine/fluid/density_rows.h"
#include "models/catalog.h"
#include "models/hydrostatic_column.h"
#include "solvers/ida_reference.h"
#include "solvers/integrators.h"
#include "solvers/reference.h"
#include "solvers/simulate.h"
#include "solvers/step_row_solver.h"
#include "tests/engine/fluid/random_fluid.h"

namespace feder {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

State run(const System& system, State state, const std::string& integrator, double dt, double end_time,
          const IntegratorOptions& options = {}) {
  Integrator method = make_integrator(integrator, system, options);
  History history;
  const RunResult result = simulate(system, method, state, history, {.dt = dt, .end_time = end_time});
  EXPECT_TRUE(result.status.ok()) << result.status.reason;
  return state;
}

HydrostaticColumn incompressible(int layers, int columns) {
  HydrostaticColumn options;
  options.layers = layers;
  options.columns = columns;
  options.sound_speed = kInfinite;
  return options;
}

double compression(const System& system, const State& state) {
  VectorXd rho;
  system.fluid->densities(state.q, rho);
  return rho.maxCoeff() / system.fluid->material().rest_density - 1.0;
}

// Largest phi + dt phidot(v') of the rows of a step from `state` to `next`.
double left_of_rows(const System& s, const State& state, const State& next, double dt) {
  DensityRows density;
  EXPECT_TRUE(density.evaluate(*s.fluid, state.q, dt));
  double left = -kInfinite;
  for (int k = 0; k < density.rows.count(); ++k)
    left = std::max(left, -dt * (density.rows.multiply_row(k, next.v.data()) + density.rows.r[k]));
  return left;
}

TEST(IncompressibleFluid, IsRefusedByNameWhereNoRowsHoldIt) {
  const Model model = make_hydrostatic_column(incompressible(6, 4));
  int refused = 0;
  for_each_integrator([&]<IntegratorType T>() {
    const Integrator method = make_integrator(T::kInfo.name, model.system);
    const std::string why = refusal(method, model.system);
    EXPECT_EQ(why.empty(), std::string(T::kInfo.name) == "symplectic_euler") << T::kInfo.name;
    if (!why.empty()) {
      ++refused;
      EXPECT_NE(why.find("incompressible fluid"), std::string::npos) << why;
    }
  });
  EXPECT_GE(refused, 6);
}

TEST(IncompressibleFluid, HasNoJudge) {
  const Model model = make_hydrostatic_column(incompressible(6, 4));
  const Reference judge = make_reference(model.system, model.state, 0.01, {});
  EXPECT_EQ(judge.status.code, StatusCode::kRefused);
  EXPECT_NE(judge.status.reason.find("incompressible"), std::string::npos);
  EXPECT_EQ(ida_solve(model.system, model.state, 0.01, {}).status.code, StatusCode::kRefused);
}

TEST(IncompressibleFluid, ColumnKeepsItsDensity) {
  const Model model = make_hydrostatic_column(incompressible(12, 6));
  const double dt = 2e-3;
  EXPECT_LT(compression(model.system, run(model.system, model.state, "symplectic_euler", dt, 0.1)),
            1e-4);  // 1.8e-6
  // sweeps leave more, the fewer the more
  double last = 0.0;
  for (int sweeps : {200, 20, 2}) {
    const double left = compression(model.system, run(model.system, model.state, "symplectic_euler", dt, 0.1,
                                                      {.route = "sweeps", .sweeps = sweeps}));
    EXPECT_GT(left, last) << sweeps;
    last = left;
  }
  EXPECT_GT(last, 3e-4);  // 6e-4
}

TEST(IncompressibleFluid, WithoutItsRowsTheColumnFallsThroughTheFloor) {
  HydrostaticColumn options = incompressible(12, 6);
  options.sound_speed = 1e-3;  // as good as no pressure
  const Model model = make_hydrostatic_column(options);
  auto lowest = [](const Model& m) {
    const State end = run(m.system, m.state, "symplectic_euler", 2e-3, 0.1);
    double y = kInfinite;
    for (int i : m.system.fluid->particles()) y = std::min(y, end.q[3 * i + 1]);
    return y;
  };
  EXPECT_LT(lowest(model), 0.0);
  EXPECT_GT(lowest(make_hydrostatic_column(incompressible(12, 6))), 0.02);
}

TEST(IncompressibleFluid, SweepsConvergeToTheDirectSolve) {
  const Model model = make_hydrostatic_column(incompressible(10, 5));
  const System& s = model.system;
  DensityRows density;
  const double dt = 2e-3;
  ASSERT_TRUE(density.evaluate(*s.fluid, model.state.q, dt));
  VectorXd kicked = model.state.v;
  for (int i : s.fluid->particles()) kicked[3 * i + 1] -= 9.81 * dt;
  for (int k = 0; k < density.rows.count(); ++k)
    density.rows.gamma[k] = 1e-3 * density.rows.mobility(k, s.inverse_mass);
  VectorXd direct = kicked, y;
  StepRowSolver solver;
  const Status status = solver.solve(density.rows, s.inverse_mass, direct, y);
  ASSERT_TRUE(status.ok()) << status.reason;
  EXPECT_GT((direct - kicked).norm(), 0.01);
  // the complementarity of pushes
  int pushing = 0;
  for (int k = 0; k < density.rows.count(); ++k) {
    const double w =
        density.rows.multiply_row(k, direct.data()) + density.rows.gamma[k] * y[k] + density.rows.r[k];
    EXPECT_GE(y[k], 0.0);
    EXPECT_GT(w, -1e-10);
    EXPECT_NEAR(y[k] * w, 0.0, 1e-10);
    pushing += y[k] > 0.0;
  }
  EXPECT_GT(pushing, 20);
  double last = 1.0;
  for (int sweeps : {10, 100, 1000, 10000}) {
    VectorXd swept = kicked, z = VectorXd::Zero(y.size());
    for (int i = 0; i < sweeps; ++i) (void)sweep_step_rows(density.rows, s.inverse_mass, swept, z);
    const double off = (swept - direct).norm() / (direct - kicked).norm();
    EXPECT_LT(off, last) << sweeps;
    last = off;
  }
  EXPECT_LT(last, 1e-6);  // 7e-8
}

TEST(IncompressibleFluid, DirectRouteClosesItsRows) {
  const double dt = 2e-3;
  for (const char* name : {"hydrostatic_column:sound_speed=inf,layers=40,columns=20",
                           "dam_break:sound_speed=inf,layers=6,slices=5,width=0.4,length=0.8",
                           "floating_body:sound_speed=inf"}) {
    const Model model = make_model(name);
    const State next = run(model.system, model.state, "symplectic_euler", dt, dt);
    EXPECT_LT(left_of_rows(model.system, model.state, next, dt), 1.01e-9) << name;  // up to 9.9e-10
    const State swept =
        run(model.system, model.state, "symplectic_euler", dt, dt, {.route = "sweeps", .sweeps = 100});
    EXPECT_GT(left_of_rows(model.system, model.state, swept, dt), 1e-8) << name;
  }
}

TEST(IncompressibleFluid, RowsKeepMomentumBodiesIncluded) {
  Random random(7);
  RandomFluid options;
  options.walls = false;
  options.particles = 300;
  options.material.sound_speed = kInfinite;
  options.material.rest_density = 1500.0;
  const auto [system, start] = random_fluid(random, options);
  for (const char* route : {"auto", "sweeps"}) {
    const State end = run(system, start, "symplectic_euler", 1e-3, 1e-3, {.route = route});
    double size = 0.0;
    for (int i = 0; i < system.places(); ++i) size += system.mass[i] * end.v.segment<3>(3 * i).norm();
    EXPECT_GT((end.v - start.v).norm(), 0.05 * start.v.norm());
    for (const Body& b : system.bodies) EXPECT_GT((end.v - start.v).segment<3>(3 * b.centre).norm(), 0.01);
    EXPECT_LT((linear_momentum(system, end) - linear_momentum(system, start)).norm(), 1e-12 * size)
        << route;  // 5e-17
  }
}

TEST(IncompressibleFluid, ATankTooFullIsRefusedByItsRows) {
  // three particles on a line between walls that leave them nine tenths of their room
  SystemBuilder builder;
  std::vector<int> nodes;
  std::vector<BoundarySample> walls;
  for (int i = 0; i < 3; ++i)
    nodes.push_back(builder.add_particle(1000.0, {0.9 * i, 0.0, 0.0}, {0.1 * i, 0.0, 0.0}, 1).node);
  for (double x : {-2.9, -1.9, -0.9, 2.7, 3.7, 4.7}) walls.push_back({{.point = {x, 0.0, 0.0}}, 1.0});
  builder.set_fluid(std::make_shared<Fluid>(
      FluidMaterial{.dimension = 1, .support = 3.0, .sound_speed = kInfinite}, nodes, walls));
  const auto [system, start] = builder.build();
  State state = start;
  Integrator method = make_integrator("symplectic_euler", system);
  History history;
  const RunResult result = simulate(system, method, state, history, {.dt = 1e-2, .end_time = 0.1});
  EXPECT_EQ(result.status.code, StatusCode::kNotConverged);
  EXPECT_NE(result.status.reason.find("do not close"), std::string::npos) << result.status.reason;
}

TEST(IncompressibleFluid, ARouteThatItsRowsDoNotTakeIsRefused) {
  const Model model = make_model("dam_break:sound_speed=inf,layers=4,width=0.5");
  for (const char* route : {"auto", "dual", "sweeps", "primal", "kkt"}) {
    Integrator method = make_integrator("symplectic_euler", model.system, {.route = route});
    const Status status = std::visit([](auto& m) { return m.prepare(); }, method);
    const bool refused = std::string(route) == "primal" || std::string(route) == "kkt";
    EXPECT_EQ(status.code, refused ? StatusCode::kRefused : StatusCode::kOk) << route;
    if (refused) EXPECT_NE(status.reason.find(route), std::string::npos) << status.reason;
  }
}

TEST(IncompressibleFluid, AResumedRunIsBitwiseEqual) {
  for (const char* route : {"auto", "sweeps"})
    for (const char* name : {"dam_break:sound_speed=inf,layers=8",
                             "floating_body:sound_speed=inf,wide=4,high=4,columns=8,layers=5"}) {
      const Model model = make_model(name);
      const State through =
          run(model.system, model.state, "symplectic_euler", 0x1p-9, 0x1p-6, {.route = route});
      const State half = run(model.system, model.state, "symplectic_euler", 0x1p-9, 0x1p-7, {.route = route});
      const State resumed = run(model.system, half, "symplectic_euler", 0x1p-9, 0x1p-6, {.route = route});
      EXPECT_GT((through.q - half.q).norm(), 1e-4);
      EXPECT_TRUE(through.q == resumed.q && through.v == resumed.v) << name << ' ' << route;
    }
}

TEST(IncompressibleFluid, AParticleBetweenEqualWallsIsNotThrownByRounding) {
  for (double gap : {1.0, 0.9}) {
    SystemBuilder builder;
    const int node = builder.add_particle(1000.0, {0.5 * gap, 0.0, 0.0}, Vector3d::Zero(), 1).node;
    std::vector<BoundarySample> walls;
    for (int k = 0; k < 3; ++k)
      for (double x : {-0.5 * gap - k, 1.5 * gap + k}) walls.push_back({{.point = {x, 0.0, 0.0}}, 1.0});
    FluidMaterial material{.dimension = 1, .support = 3.0, .sound_speed = kInfinite};
    material.rest_density = gap == 1.0 ? 1100.0 : 1000.0;  // room enough, and not
    builder.set_fluid(std::make_shared<Fluid>(material, std::vector<int>{node}, walls));
    const auto [system, start] = builder.build();
    State state = start;
    Integrator method = make_integrator("symplectic_euler", system);
    History history;
    const RunResult result = simulate(system, method, state, history, {.dt = 1e-2, .end_time = 0.05});
    EXPECT_LT(state.v.norm(), 1e-6) << gap;  // 7e16 where rounding pushes
    EXPECT_EQ(result.status.code, gap == 1.0 ? StatusCode::kOk : StatusCode::kNotConverged) << gap;
  }
}

TEST(IncompressibleFluid, APoorGuessWhichRowsPushTakesFewFactors) {
  Model model = make_model("bath:sound_speed=inf,spacing=0.2,layers=3,columns=5");
  const System& s = model.system;
  const double dt = 2e-3;
  StepRowSolver solver;
  int most = 0;
  for (int step = 0; step < 6; ++step) {
    DensityRows density;
    ASSERT_TRUE(density.evaluate(*s.fluid, model.state.q, dt));
    ASSERT_GT(density.rows.count(), 300);
    VectorXd v = model.state.v, y = (density.phi.array() > -1e-3).cast<double>();
    for (int i = 0; i < s.places(); ++i) v[3 * i + 1] -= s.inverse_mass[3 * i + 1] > 0.0 ? 9.81 * dt : 0.0;
    for (int k = 0; k < density.rows.count(); ++k)
      density.rows.gamma[k] = 1e-4 * density.rows.mobility(k, s.inverse_mass);
    ASSERT_TRUE(solver.solve(density.rows, s.inverse_mass, v, y).ok());
    most = std::max(most, solver.factorizations());
    model.state = run(s, model.state, "symplectic_euler", dt, model.state.t + dt);
  }
  EXPECT_GT(most, 4);
  EXPECT_LT(most, 80);  // 31, without the line search 378
}

TEST(IncompressibleFluid, LedgerClosesAndAFailedStepLeavesTheState) {
  const Model model = make_hydrostatic_column(incompressible(8, 4));
  Integrator method = make_integrator("symplectic_euler", model.system);
  ASSERT_TRUE(std::visit([](auto& m) { return m.prepare(); }, method).ok());
  State state = model.state;
  History history;
  EnergyLedger ledger;
  auto step = [&] {
    return std::visit([&](auto& m) { return m.step(2e-3, state, history, &ledger); }, method);
  };
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(step().ok());
    EXPECT_GT(std::abs(ledger.row_work), 1e-6);  // the pressure
    EXPECT_LT(std::abs(ledger.imbalance()), 1e-13 * ledger.magnitude());
  }
  state.q[4] = std::nan("");
  const State before = state;
  const Status status = step();
  EXPECT_EQ(status.code, StatusCode::kNonFinite);
  EXPECT_TRUE(state.v == before.v && state.t == before.t);
}

}  // namespace
}  // namespace feder
