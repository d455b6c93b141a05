// Fluids in time: what leapfrog keeps, what the density rows hold, and figures of textbooks.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "engine/body.h"
#include "engine/energy.h"
#include "models/catalog.h"
#include "models/dam_break.h"
#include "models/floating_body.h"
#include "models/hydrostatic_column.h"
#include "solvers/fluid_stability.h"
#include "solvers/ida_reference.h"
#include "solvers/integrators.h"
#include "solvers/reference.h"
#include "solvers/simulate.h"
#include "solvers/stability.h"
#include "tests/engine/fluid/random_fluid.h"

namespace feder {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

// 0.2 of the time sound takes through the support.
double sound_step(const System& system, double part = 0.2) {
  return part * system.fluid->material().support / system.fluid->material().sound_speed;
}

State run(const System& system, State state, const std::string& integrator, double dt, double end_time,
          const IntegratorOptions& options = {}) {
  Integrator method = make_integrator(integrator, system, options);
  History history;
  const RunResult result = simulate(system, method, state, history, {.dt = dt, .end_time = end_time});
  EXPECT_TRUE(result.status.ok()) << result.status.reason;
  return state;
}

TEST(FluidRun, LeapfrogKeepsTheEnergyToTheSecondOrder) {
  DamBreak options;
  options.layers = 10;
  options.width = 0.5;
  options.exponent = 1.0;
  const Model model = make_dam_break(options);
  const double start = total_energy(model.system, model.state);
  double drift[2];
  for (int i = 0; i < 2; ++i) {
    const double dt = sound_step(model.system) / (1 << i);
    const State end = run(model.system, model.state, "leapfrog", dt, 0.2);
    EXPECT_GT(kinetic_energy(model.system, end), 0.1 * start);
    drift[i] = std::abs(total_energy(model.system, end) - start) / start;
    EXPECT_GT(drift[i], 0.0);
  }
  EXPECT_LT(drift[0], 1e-3);
  EXPECT_LT(drift[1], 0.5 * drift[0]);
}

TEST(FluidRun, MomentumStaysToRoundingBodiesIncluded) {
  Random random(5);
  RandomFluid options;
  options.walls = false;
  options.particles = 200;
  options.material.viscosity = 1.0;
  options.material.wall_drag = 1.0;
  const auto [system, start] = random_fluid(random, options);
  for (const char* integrator : {"leapfrog", "symplectic_euler", "explicit_euler"}) {
    const State end = run(system, start, integrator, 2e-4, 0.05);
    double size = 0.0;
    for (int i = 0; i < system.places(); ++i) size += system.mass[i] * end.v.segment<3>(3 * i).norm();
    EXPECT_GT((end.v - start.v).norm(), 0.05 * start.v.norm());
    EXPECT_LT((linear_momentum(system, end) - linear_momentum(system, start)).norm(), 1e-12 * size)
        << integrator;
    if (std::string(integrator) == "leapfrog")  // turns bodies freely; the others turn them by their spin
      EXPECT_LT((angular_momentum(system, end) - angular_momentum(system, start)).norm(), 1e-12 * size);
  }
}

TEST(FluidRun, MomentumOfTenThousandParticlesAndBodiesStaysToRounding) {
  Random random(6);
  RandomFluid options;
  options.walls = false;
  options.particles = 12000;
  options.samples = 200;
  options.material.support = 0.15;
  options.material.viscosity = 1.0;
  options.material.wall_drag = 1.0;
  const auto [system, start] = random_fluid(random, options);
  const State end = run(system, start, "leapfrog", 1e-4, 1e-3);
  double size = 0.0, turn = 0.0;
  for (int i = 0; i < system.places(); ++i) {
    size += system.mass[i] * end.v.segment<3>(3 * i).norm();
    turn += system.mass[i] * end.q.segment<3>(3 * i).norm() * end.v.segment<3>(3 * i).norm();
  }
  EXPECT_GT((end.v - start.v).norm(), 0.05 * start.v.norm());
  for (const Body& b : system.bodies) {
    EXPECT_GT((end.v - start.v).segment<3>(3 * b.centre).norm(), 0.05);
    EXPECT_GT((end.v - start.v).segment<3>(3 * b.spin).norm(), 0.05);
  }
  EXPECT_LT((linear_momentum(system, end) - linear_momentum(system, start)).norm(), 1e-12 * size);
  EXPECT_LT((angular_momentum(system, end) - angular_momentum(system, start)).norm(), 1e-12 * turn);  // 4e-17
}

TEST(FluidRun, ViscosityTakesEnergy) {
  DamBreak options;
  options.layers = 8;
  double last = kInfinite;
  for (double viscosity : {0.0, 5.0, 20.0}) {
    options.viscosity = viscosity;
    const Model model = make_dam_break(options);
    EXPECT_EQ(model.conserved.empty(), viscosity > 0.0);
    const State end = run(model.system, model.state, "leapfrog", sound_step(model.system, 0.1), 0.2);
    const double energy = total_energy(model.system, end);
    EXPECT_LT(energy, last);
    last = energy;
  }
}

// ---- The limit of the step

// Largest kinetic energy in 600 steps of leapfrog from a column at rest.
double most_energy(const Model& model, double dt) {
  Leapfrog leapfrog(model.system, {});
  State state = model.state;
  History history;
  double most = 0.0;
  EXPECT_TRUE(leapfrog.prepare().ok());
  for (int i = 0; i < 600; ++i) {
    if (!leapfrog.step(dt, state, history, nullptr).ok()) return kInfinite;
    most = std::max(most, kinetic_energy(model.system, state));
  }
  return most;
}

TEST(FluidStability, PredictedLimitPartsStableFromUnstable) {
  for (double viscosity : {0.0, 1e4}) {  // sound decides, viscosity decides
    HydrostaticColumn options;
    options.layers = 10;
    options.columns = 5;
    options.push = 0.0;
    options.sound_speed = 100.0;
    options.viscosity = viscosity;
    const Model model = make_hydrostatic_column(options);
    const FluidRates rates = largest_fluid_rates(model.system, model.state);
    EXPECT_GT(rates.frequency, 100.0);
    EXPECT_EQ(rates.damping > 0.0, viscosity > 0.0);
    const double limit = fluid_step_limit(rates), calm = most_energy(model, 0.5 * limit);
    EXPECT_GT(calm, 0.0);
    EXPECT_LT(most_energy(model, 0.9 * limit), 10.0 * calm) << viscosity;
    EXPECT_GT(most_energy(model, 1.3 * limit), 100.0 * calm) << viscosity;
  }
}

TEST(FluidStability, RatesAreThoseOfTwoParticles) {
  // M^-1 K = 2/m F' along the line of two particles under pressure, by their force at two distances
  SystemBuilder builder;
  FluidMaterial material{.dimension = 1, .support = 1.0, .rest_density = 1.0, .sound_speed = 2.0};
  const double m = 0.9, at = 0.3, step = 1e-6;
  const std::vector<int> nodes = {builder.add_particle(m, {0.0, 0.0, 0.0}, Vector3d::Zero(), 1).node,
                                  builder.add_particle(m, {at, 0.0, 0.0}, Vector3d::Zero(), 1).node};
  builder.set_fluid(std::make_shared<Fluid>(material, nodes));
  const auto [system, state] = builder.build();
  auto push = [&](double distance) {
    State moved = state;
    moved.q[3] = distance;
    VectorXd f = VectorXd::Zero(6);
    system.fluid->add_forces(moved.q, moved.v, f);
    return f[3];
  };
  EXPECT_GT(push(at), 0.1);
  const double stiffness = -(push(at + step) - push(at - step)) / (2.0 * step);
  EXPECT_NEAR(largest_fluid_rates(system, state).frequency, std::sqrt(2.0 * stiffness / m),
              1e-6 * std::sqrt(2.0 * stiffness / m));
}

TEST(FluidRun, LeapfrogMeetsTheJudge) {
  HydrostaticColumn options;
  options.layers = 6;
  options.columns = 4;
  options.push = 0.5;
  const Model model = make_hydrostatic_column(options);
  const double time = 0.05;
  const Reference judge = make_reference(model.system, model.state, time, {});
  ASSERT_TRUE(judge.status.ok()) << judge.status.reason;
  double error[2];
  for (int i = 0; i < 2; ++i)
    error[i] = position_error(model.system, judge.state,
                              run(model.system, model.state, "leapfrog", 5e-4 / (1 << i), time));
  EXPECT_LT(judge.error, 0.01 * error[1]);
  EXPECT_NEAR(error[0] / error[1], 4.0, 0.4);  // second order
}

TEST(FluidStability, LimitsOfASystemIncludeItsFluid) {
  const Model model = make_hydrostatic_column();
  const FluidRates rates = largest_fluid_rates(model.system, model.state);
  EXPECT_GT(rates.frequency, 100.0);
  EXPECT_EQ(largest_frequency(model.system, model.state), rates.frequency);
  EXPECT_DOUBLE_EQ(stability_limit("leapfrog", model.system, model.state).dt, 2.0 / rates.frequency);
  EXPECT_EQ(stability_limit("explicit_euler", model.system, model.state).dt, 0.0);
  EXPECT_TRUE(std::isnan(stability_limit("implicit_euler_newton", model.system, model.state).dt));
  const StabilityForecast forecast = forecast_stability(model.system, model.state, {"rk4"});
  EXPECT_EQ(forecast.spectrum.largest_frequency, rates.frequency);
  EXPECT_NEAR(forecast.limits[0].dt, 2.8284 / rates.frequency, 1e-3 / rates.frequency);
  EXPECT_NE(forecast.limits[0].why.find("fluid"), std::string::npos);
}

// ---- Figures of textbooks

TEST(HydrostaticColumn, PressureIsTheWeightAboveWithinTwoPerCent) {
  HydrostaticColumn options;
  options.columns = 24;
  options.drag = 20.0;
  options.viscosity = 3.0;
  options.push = 0.0;
  const Model model = make_hydrostatic_column(options);
  const State end = run(model.system, model.state, "leapfrog", sound_step(model.system), 4.0);
  EXPECT_LT(end.v.lpNorm<Eigen::Infinity>(), 0.05);
  VectorXd rho;
  const Fluid& fluid = *model.system.fluid;
  fluid.densities(end.q, rho);
  // layer by layer, between a support over the floor and the upper third
  double sum[4] = {}, ideal[4] = {};
  for (std::size_t i = 0; i < fluid.particles().size(); ++i) {
    const double y = end.q[3 * fluid.particles()[i] + 1];
    const int part = static_cast<int>(std::floor((y - 0.125) / 0.125));
    if (part < 0 || part > 3) continue;
    sum[part] += fluid.pressure(rho[i]);
    ideal[part] += 1000.0 * 9.81 * (1.0 - y);
  }
  for (int part = 0; part < 4; ++part) {
    EXPECT_GT(ideal[part], 1e5);
    EXPECT_NEAR(sum[part] / ideal[part], 1.0, 0.02) << part;  // 0.987 to 1.005
  }
}

TEST(FloatingBody, LiesAtArchimedesDepthWithinTwoPerCent) {
  FloatingBody options;
  options.spacing = 0.025;
  options.wide = options.high = 24;
  options.drag = 5.0;
  options.viscosity = 3.0;
  const Model model = make_floating_body(options);
  const State end = run(model.system, model.state, "leapfrog", sound_step(model.system), 3.0);
  const double archimedes = options.density * options.high * options.spacing;
  EXPECT_NEAR(draft(options, model.system, end) / archimedes, 1.0, 0.02);  // 1.0165
}

TEST(FloatingBody, SinksWhereItIsHeavierAndRisesWhereItIsDeeper) {
  FloatingBody heavy;
  heavy.density = 3.0;
  heavy.wide = heavy.high = 6;
  const Model sinking = make_floating_body(heavy);
  const int centre = sinking.system.bodies[0].centre;
  const State end =
      run(sinking.system, sinking.state, "leapfrog", sound_step(sinking.system), sinking.end_time);
  EXPECT_LT(end.q[3 * centre + 1], sinking.state.q[3 * centre + 1] - 0.1);
  EXPECT_GT(end.q[3 * centre + 1], 0.0);
  FloatingBody light;
  light.density = 0.3;
  light.lift = -0.05;
  const Model rising = make_floating_body(light);
  const State up = run(rising.system, rising.state, "leapfrog", sound_step(rising.system), 0.15);
  EXPECT_GT(up.q[3 * rising.system.bodies[0].centre + 1],
            rising.state.q[3 * rising.system.bodies[0].centre + 1]);
}

TEST(DamBreak, FrontStaysBehindRitterAndConverges) {
  const double time = 0.25, height = 0.5, ritter = 2.0 * std::sqrt(9.81 * height) * time;
  double reach[3];
  for (int i = 0; i < 3; ++i) {
    DamBreak options;
    options.layers = 8 << i;
    const Model model = make_dam_break(options);
    const double spacing = height / options.layers;
    const State end = run(model.system, model.state, "leapfrog", sound_step(model.system), time);
    reach[i] = front(model.system, end, 1.5 * spacing) - options.width;
    EXPECT_LT(reach[i], ritter) << options.layers;  // 0.36, 0.45, 0.47 of it
    EXPECT_GT(reach[i], 0.3 * ritter) << options.layers;
  }
  EXPECT_LT(std::abs(reach[2] - reach[1]), std::abs(reach[1] - reach[0]));
}

}  // namespace
}  // namespace feder
