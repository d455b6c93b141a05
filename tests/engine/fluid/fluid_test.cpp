// Smoothed mass (notes G1): densities, and forces that are the gradient of an energy.
#include "engine/fluid/fluid.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <numbers>

#include "engine/body.h"
#include "engine/energy.h"
#include "engine/kkt.h"
#include "tests/engine/fluid/random_fluid.h"
#include "tests/support/finite_difference.h"
#include "tests/support/refused.h"

namespace feder {
namespace {

using test::refused;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

// A lattice of `cells` particles along each axis, `spacing` apart.
SystemBuilder::Built lattice(const FluidMaterial& material, int cells, double spacing) {
  SystemBuilder builder;
  const int D = material.dimension;
  std::vector<int> nodes;
  const double mass = material.rest_density * std::pow(spacing, D);
  for (int i = 0; i < static_cast<int>(std::pow(cells, D) + 0.5); ++i) {
    Vector3d x = Vector3d::Zero();
    for (int c = 0, rest = i; c < D; ++c, rest /= cells) x[c] = spacing * (rest % cells);
    nodes.push_back(
        builder.add_particle(mass, x, Vector3d::Zero(), static_cast<FreeMask>((1 << D) - 1)).node);
  }
  builder.set_fluid(std::make_shared<Fluid>(material, nodes));
  return builder.build();
}

// Error of the density in the middle of a lattice.
double lattice_error(SmoothingKernel kernel, int dimension, double support) {
  FluidMaterial material{.dimension = dimension, .kernel = kernel, .support = support, .rest_density = 800.0};
  const int cells = 2 * static_cast<int>(std::ceil(support)) + 1;
  const auto [system, state] = lattice(material, cells, 1.0);
  VectorXd rho;
  system.fluid->densities(state.q, rho);
  return rho.maxCoeff() / 800.0 - 1.0;  // in the middle
}

TEST(Fluid, DensityOfALatticeIsConstantToOnePerCent) {  // G1
  for (int dimension = 1; dimension <= 3; ++dimension)
    for (double support : {3.0, 3.5, 4.0})
      for (SmoothingKernel kernel : {SmoothingKernel::kPoly6, SmoothingKernel::kCubicSpline,
                                     SmoothingKernel::kWendland2, SmoothingKernel::kWendland4}) {
        const double error = lattice_error(kernel, dimension, support);
        EXPECT_NE(error, 0.0);
        EXPECT_LT(std::abs(error), 0.01) << to_string(kernel) << ' ' << dimension << ' ' << support;  // 0.5 %
      }
}

TEST(Fluid, SpikyNeedsMoreNeighboursForOnePerCent) {
  EXPECT_GT(std::abs(lattice_error(SmoothingKernel::kSpiky, 3, 3.0)), 0.01);  // 4.7 %
  EXPECT_LT(std::abs(lattice_error(SmoothingKernel::kSpiky, 3, 4.5)), 0.01);  // 0.9 %
}

TEST(Fluid, ThePrintedPoly6SeesWhichNeighboursAreInside) {
  // its border does not fade: 2.5 % at three spacings, and not less with more of them
  EXPECT_LT(lattice_error(SmoothingKernel::kPoly6Printed, 3, 3.0), -0.02);
  EXPECT_GT(lattice_error(SmoothingKernel::kPoly6Printed, 3, 3.5), 0.005);
  EXPECT_LT(std::abs(lattice_error(SmoothingKernel::kPoly6, 3, 3.0)), 0.0025);
}

TEST(Fluid, DensityIsTheSumOverAllPairs) {
  Random random(11);
  for (int dimension = 1; dimension <= 3; ++dimension) {
    RandomFluid options;
    options.material.dimension = dimension;
    const auto [system, state] = random_fluid(random, options);
    const Fluid& fluid = *system.fluid;
    VectorXd rho;
    fluid.densities(state.q, rho);
    for (std::size_t i = 0; i < fluid.particles().size(); ++i) {
      const Vector3d x = state.q.segment<3>(3 * fluid.particles()[i]);
      double sum = 0.0;
      for (std::size_t j = 0; j < fluid.masses().size(); ++j) {
        const std::size_t particles = fluid.particles().size();
        const Vector3d other = j < particles ? Vector3d(state.q.segment<3>(3 * fluid.particles()[j]))
                                             : sample_position(fluid.samples()[j - particles], state.q);
        sum += fluid.masses()[j] * kernel_value(options.material.kernel, dimension, options.material.support,
                                                (x - other).head(dimension).norm());
      }
      EXPECT_NEAR(rho[i], sum, 1e-12 * sum);
    }
  }
}

TEST(Fluid, PressureIsTheSlopeOfTheEnergyPerMass) {
  for (double exponent : {1.0, 2.0, 7.0})
    for (bool clamp : {false, true}) {
      const Fluid fluid({.support = 1.0, .exponent = exponent, .clamp_tension = clamp}, {});
      for (double rho : {700.0, 950.0, 1010.0, 1300.0}) {
        const double step = 1e-2;
        const double slope =
            (fluid.energy_per_mass(rho + step) - fluid.energy_per_mass(rho - step)) / (2.0 * step);
        EXPECT_NEAR(fluid.pressure(rho) / (rho * rho), slope, 1e-8 * 100.0 / rho);
        EXPECT_EQ(fluid.pressure(rho) == 0.0, clamp && rho < 1000.0);
      }
      EXPECT_NEAR((fluid.pressure(1000.1) - fluid.pressure(1000.0)) / 0.1, 100.0, 0.1);  // c^2
    }
}

// Force by velocity coordinates against the change of the energy, bodies turned by their spins.
void expect_forces_are_gradient(std::uint64_t seed, RandomFluid options) {
  Random random(seed);
  options.particles = 25;
  const auto [system, state] = random_fluid(random, options);
  VectorXd f = VectorXd::Zero(state.v.size());
  system.fluid->add_forces(state.q, state.v, f);
  const VectorXd gradient = finite_gradient(
      [&](const VectorXd& step) {
        VectorXd q;
        advance(system, 1.0, step, state.q, q);
        return system.fluid->energy(q);
      },
      VectorXd::Zero(state.v.size()), 1e-5);
  for (int i : system.masked) f[i] = 0.0;
  VectorXd free_gradient = gradient;
  for (int i : system.masked) free_gradient[i] = 0.0;
  const double size = f.lpNorm<Eigen::Infinity>();
  EXPECT_GT(size, 1.0);
  EXPECT_LT((f + free_gradient).lpNorm<Eigen::Infinity>(), 1e-8 * size);
  double torque = 0.0;
  for (const Body& b : system.bodies) torque += f.segment<3>(3 * b.spin).norm();
  EXPECT_EQ(torque > 1e-3 * size, options.material.dimension > 1);
}

TEST(Fluid, ForcesAreTheGradientOfTheEnergyBodiesIncluded) {
  for (int dimension = 1; dimension <= 3; ++dimension)
    for (double exponent : {1.0, 7.0}) {
      RandomFluid options;
      options.material.dimension = dimension;
      options.material.exponent = exponent;
      options.material.clamp_tension = false;
      for (SmoothingKernel kernel :
           {SmoothingKernel::kCubicSpline, SmoothingKernel::kWendland2, SmoothingKernel::kWendland4}) {
        options.material.kernel = kernel;
        SCOPED_TRACE(std::string(to_string(kernel)) + " " + std::to_string(dimension));
        expect_forces_are_gradient(21, options);
      }
    }
}

// Sum of forces and of moments about the origin, bodies' torques turned into world axes.
std::pair<Vector3d, Vector3d> sums(const System& s, const State& state, const VectorXd& f) {
  Vector3d force = Vector3d::Zero(), moment = Vector3d::Zero();
  for (int i = 0; i < s.places(); ++i) {
    const Vector3d x = state.q.segment<3>(3 * i), at = f.segment<3>(3 * i);
    force += at;
    moment += x.cross(at);
  }
  for (const Body& b : s.bodies)
    moment += rotation_matrix(state.q.data() + b.quaternion) * Vector3d(f.segment<3>(3 * b.spin));
  return {force, moment};
}

TEST(Fluid, ForcesKeepMomentumAndAngularMomentumBodiesAndViscosityIncluded) {
  Random random(31);
  for (int dimension = 2; dimension <= 3; ++dimension)
    for (double viscosity : {0.0, 50.0}) {
      RandomFluid options;
      options.material.dimension = dimension;
      options.material.viscosity = viscosity;
      options.material.wall_drag = 1.0;
      options.walls = false;  // the world takes what it is given
      options.particles = 300;
      const auto [system, state] = random_fluid(random, options);
      VectorXd f = VectorXd::Zero(state.v.size());
      system.fluid->add_forces(state.q, state.v, f);
      const auto [force, moment] = sums(system, state, f);
      const double size = f.head(3 * system.places()).cwiseAbs().sum();
      EXPECT_GT(size, 100.0);
      EXPECT_LT(force.norm(), 1e-12 * size);
      EXPECT_LT(moment.norm(), 1e-12 * size);
    }
}

TEST(Fluid, ViscosityOnlyTakesEnergyAndStopsWhereAllMoveAlike) {
  Random random(41);
  RandomFluid options;
  options.material.viscosity = 20.0;
  options.material.sound_speed = kInfinite;  // viscous forces alone
  options.material.wall_drag = 1.0;
  options.walls = false;
  auto [system, state] = random_fluid(random, options);
  VectorXd f = VectorXd::Zero(state.v.size());
  system.fluid->add_forces(state.q, state.v, f);
  EXPECT_LT(f.dot(state.v), -1.0);
  // a rigid motion of all
  const Vector3d w(0.3, -0.8, 0.5), u(1.0, 2.0, -1.0);
  for (int i = 0; i < system.places(); ++i)
    state.v.segment<3>(3 * i) = u + w.cross(Vector3d(state.q.segment<3>(3 * i)));
  for (const Body& b : system.bodies)
    state.v.segment<3>(3 * b.spin) = rotation_matrix(state.q.data() + b.quaternion).transpose() * w;
  const double size = f.norm();
  f.setZero();
  system.fluid->add_forces(state.q, state.v, f);
  EXPECT_LT(f.norm(), 1e-12 * size);
}

TEST(Fluid, ForcesOfASystemIncludeItAndLeaveMaskedCoordinates) {
  Random random(51);
  RandomFluid options;
  options.material.dimension = 2;
  const auto [system, state] = random_fluid(random, options);
  VectorXd all, own = VectorXd::Zero(state.v.size());
  const Status status = evaluate_forces(system, state, all);
  ASSERT_TRUE(status.ok()) << status.reason;
  system.fluid->add_forces(state.q, state.v, own);
  for (int i : system.masked) {
    EXPECT_EQ(all[i], 0.0);
    own[i] = 0.0;
  }
  EXPECT_GT(own.norm(), 1.0);
  EXPECT_TRUE(all == own);
  EXPECT_GT(system.fluid->energy(state.q), 1.0);
  EXPECT_EQ(external_energy(system, state), system.fluid->energy(state.q));
}

TEST(Fluid, ResultsDoNotDependOnEarlierCalls) {
  Random random(61);
  RandomFluid options;
  options.material.viscosity = 1.0;
  const auto [system, state] = random_fluid(random, options);
  options.material.dimension = 2;
  options.particles = 200;
  const auto [other, other_state] = random_fluid(random, options);
  VectorXd first = VectorXd::Zero(state.v.size()), again = first,
           between = VectorXd::Zero(other_state.v.size());
  system.fluid->add_forces(state.q, state.v, first);
  other.fluid->add_forces(other_state.q, other_state.v, between);
  system.fluid->add_forces(state.q, state.v, again);
  EXPECT_TRUE(first == again);
}

TEST(Fluid, APositionThatIsNotFiniteIsNamed) {
  Random random(71);
  auto [system, state] = random_fluid(random, {});
  state.q[3 * 4 + 1] = std::nan("");
  VectorXd f;
  const Status status = evaluate_forces(system, state, f);
  EXPECT_EQ(status.code, StatusCode::kNonFinite);
  EXPECT_NE(status.reason.find("node 4"), std::string::npos) << status.reason;
  EXPECT_TRUE(std::isnan(system.fluid->energy(state.q)));
}

TEST(Fluid, APositionThatIsNotFiniteIsNoticedBehindMasks) {
  // particle 1 moves along y alone, node 2, which holds a sample, along no axis
  SystemBuilder builder;
  const std::vector<int> nodes = {
      builder.add_particle(1.0, {0.0, 0.0, 0.0}, Vector3d::Zero(), kPlanarXY).node,
      builder.add_particle(1.0, {0.1, 0.0, 0.0}, Vector3d::Zero(), 2).node};
  const int held = builder.add_world_point({0.0, 0.1, 0.0}).node;
  const FluidMaterial material{.dimension = 2, .support = 0.3, .rest_density = 10.0};
  builder.set_fluid(
      std::make_shared<Fluid>(material, nodes, std::vector<BoundarySample>{{{.node = held}, 0.01}}));
  const auto [system, state] = builder.build();
  VectorXd f;
  ASSERT_TRUE(evaluate_forces(system, state, f).ok());
  EXPECT_GT(f.norm(), 1.0);
  for (int coordinate : {3 * nodes[1] + 1, 3 * held}) {
    State bad = state;
    bad.q[coordinate] = std::nan("");
    EXPECT_EQ(evaluate_forces(system, bad, f).code, StatusCode::kNonFinite) << coordinate;
  }
}

TEST(Fluid, BoundarySamplesOfAPlaneFillWhatItCutsOff) {
  // three layers of samples below a half space of fluid
  FluidMaterial material{.dimension = 2, .support = 3.0, .rest_density = 1000.0};
  SystemBuilder builder;
  std::vector<int> nodes;
  std::vector<BoundarySample> walls;
  for (int i = -8; i <= 8; ++i) {
    for (int j = 0; j < 6; ++j)
      nodes.push_back(
          builder.add_particle(1000.0, {1.0 * i, 0.5 + j, 0.0}, Vector3d::Zero(), kPlanarXY).node);
    for (int j = 0; j < 3; ++j) walls.push_back({{.point = {1.0 * i, -0.5 - j, 0.0}}});
  }
  builder.set_fluid(std::make_shared<Fluid>(material, nodes, walls));
  const auto [system, state] = builder.build();
  VectorXd rho;
  system.fluid->densities(state.q, rho);
  EXPECT_NEAR(rho[8 * 6] / 1000.0, 1.0, 0.1);
  EXPECT_NEAR(rho[8 * 6 + 2] / 1000.0, 1.0, 0.01);
}

TEST(Fluid, BadInputIsRefusedByNameAndValue) {
  auto build = [](FluidMaterial material, std::vector<int> nodes, std::vector<BoundarySample> boundary = {}) {
    return [=] {
      SystemBuilder builder;
      builder.add_particle(1.0, {0.0, 0.0, 0.0});
      builder.add_world_point({1.0, 0.0, 0.0});
      builder.set_fluid(std::make_shared<Fluid>(material, nodes, boundary));
      (void)builder.build();
    };
  };
  const FluidMaterial good{.support = 0.1};
  EXPECT_NO_THROW(build(good, {0})());
  EXPECT_TRUE(refused("fluid: support = 0 m", build({}, {0})));
  EXPECT_TRUE(refused("fluid: dimension = 4", build({.dimension = 4, .support = 0.1}, {0})));
  EXPECT_TRUE(refused("fluid: kernel = viscosity",
                      build({.kernel = SmoothingKernel::kViscosity, .support = 0.1}, {0})));
  EXPECT_TRUE(refused("fluid: sound speed = -1 m/s", build({.support = 0.1, .sound_speed = -1.0}, {0})));
  EXPECT_TRUE(refused("fluid: exponent = 0.5", build({.support = 0.1, .exponent = 0.5}, {0})));
  EXPECT_TRUE(refused("fluid: viscosity = -2 Pa s", build({.support = 0.1, .viscosity = -2.0}, {0})));
  EXPECT_TRUE(refused("fluid: node = 7", build(good, {7})));
  EXPECT_TRUE(refused("fluid, node 1: mass = 0 kg", build(good, {1})));
  EXPECT_TRUE(refused("fluid, node 0: named twice", build(good, {0, 0})));
  EXPECT_TRUE(refused("fluid, node 0: free mask = 7", build({.dimension = 2, .support = 0.1}, {0})));
  EXPECT_TRUE(refused("fluid boundary: body = 3", build(good, {0}, {{{.body = 3}}})));
  EXPECT_TRUE(refused("fluid boundary: node = 9", build(good, {0}, {{{.node = 9}}})));
  EXPECT_TRUE(refused("fluid boundary: volume = -1 m^D", build(good, {0}, {{.at = {}, .volume = -1.0}})));
  EXPECT_TRUE(
      refused("fluid boundary: density = -1 kg/m^D", build(good, {0}, {{.at = {}, .density = -1.0}})));
  EXPECT_TRUE(refused("fluid boundary: point", build(good, {0}, {{{.point = {0.0, kInfinite, 0.0}}}})));
}

}  // namespace
}  // namespace feder
