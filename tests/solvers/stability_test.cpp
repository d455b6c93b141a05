// Predicted limits against the amplification matrix of one step, from both sides.
#include "solvers/stability.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/kkt.h"
#include "solvers/symplectic_euler.h"
#include "tests/support/finite_difference.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace feder {
namespace {

using Eigen::MatrixXd;
using std::numbers::pi;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double spectral_radius(const MatrixXd& A) {
  return Eigen::EigenSolver<MatrixXd>(A, false).eigenvalues().cwiseAbs().maxCoeff();
}

// ---- One step of each method on M x'' + C x' + K x = 0, as a matrix on (x, v); here M = E

MatrixXd first_order(const MatrixXd& K, const MatrixXd& C) {
  const auto n = K.rows();
  MatrixXd A = MatrixXd::Zero(2 * n, 2 * n);
  A.topRightCorner(n, n).setIdentity();
  A.bottomLeftCorner(n, n) = -K;
  A.bottomRightCorner(n, n) = -C;
  return A;
}

MatrixXd explicit_euler_step(const MatrixXd& K, const MatrixXd& C, double dt) {
  return MatrixXd::Identity(2 * K.rows(), 2 * K.rows()) + dt * first_order(K, C);
}

MatrixXd rk4_step(const MatrixXd& K, const MatrixXd& C, double dt) {
  const MatrixXd z = dt * first_order(K, C), E = MatrixXd::Identity(z.rows(), z.cols());
  return E + z * (E + z / 2.0 * (E + z / 3.0 * (E + z / 4.0)));
}

// v' = v - dt (K x + C v);  x' = x + dt v'
MatrixXd symplectic_euler_step(const MatrixXd& K, const MatrixXd& C, double dt) {
  const auto n = K.rows();
  MatrixXd kick = MatrixXd::Identity(2 * n, 2 * n), drift = kick;
  kick.bottomLeftCorner(n, n) = -dt * K;
  kick.bottomRightCorner(n, n) -= dt * C;
  drift.topRightCorner(n, n) = dt * MatrixXd::Identity(n, n);
  return drift * kick;
}

// v+ = v + dt/2 (a(x) - C v);  x' = x + dt v+;  (1 + dt/2 C) v' = v+ + dt/2 a(x')
MatrixXd leapfrog_step(const MatrixXd& K, const MatrixXd& C, double dt) {
  const auto n = K.rows();
  const MatrixXd E = MatrixXd::Identity(n, n);
  MatrixXd kick = MatrixXd::Identity(2 * n, 2 * n), drift = kick, second = kick;
  kick.bottomLeftCorner(n, n) = -0.5 * dt * K;
  kick.bottomRightCorner(n, n) = E - 0.5 * dt * C;
  drift.topRightCorner(n, n) = dt * E;
  const MatrixXd solve = (E + 0.5 * dt * C).inverse();
  second.bottomLeftCorner(n, n) = -0.5 * dt * solve * K;
  second.bottomRightCorner(n, n) = solve;
  return second * drift * kick;
}

// (M + dt C + dt^2 Km) v' = M v - dt (Km + Kg) x;  x' = x + dt v'
MatrixXd notes_step(const MatrixXd& M, const MatrixXd& Km, const MatrixXd& Kg, const MatrixXd& C, double dt) {
  const auto n = M.rows();
  const MatrixXd solve = (M + dt * C + dt * dt * Km).inverse();
  MatrixXd A(2 * n, 2 * n);
  A.bottomLeftCorner(n, n) = -dt * solve * (Km + Kg);
  A.bottomRightCorner(n, n) = solve * M;
  A.topRows(n) = dt * A.bottomRows(n);
  A.topLeftCorner(n, n) += MatrixXd::Identity(n, n);
  return A;
}

MatrixXd scalar(double x) {
  return MatrixXd::Constant(1, 1, x);
}

struct Mode {
  double omega_squared, c;
};

Mode random_mode(Random& random) {
  const double omega = std::pow(10.0, random.uniform(-2.0, 4.0)),
               zeta = std::pow(10.0, random.uniform(-1.5, 1.0));
  return {omega * omega, 2.0 * zeta * omega};
}

using Limit = double (*)(double, double);
using Step = MatrixXd (*)(const MatrixXd&, const MatrixXd&, double);

void expect_sharp(Limit limit, Step step, const Mode& mode) {
  const double dt = limit(mode.omega_squared, mode.c);
  EXPECT_LE(spectral_radius(step(scalar(mode.omega_squared), scalar(mode.c), 0.999 * dt)), 1.0 + 1e-12);
  EXPECT_GT(spectral_radius(step(scalar(mode.omega_squared), scalar(mode.c), 1.001 * dt)), 1.0);
}

TEST(ModeLimits, ExplicitEulerIsSharpOnBothSides) {
  Random random(1);
  for (int i = 0; i < 200; ++i) expect_sharp(explicit_euler_limit, explicit_euler_step, random_mode(random));
}

TEST(ModeLimits, LeapfrogIsSharpOnBothSidesWhateverTheDamping) {
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const Mode mode = random_mode(random);
    EXPECT_DOUBLE_EQ(leapfrog_limit(mode.omega_squared, mode.c), 2.0 / std::sqrt(mode.omega_squared));
    expect_sharp(leapfrog_limit, leapfrog_step, mode);
  }
}

TEST(ModeLimits, SymplecticEulerIsSharpOnBothSides) {
  Random random(7);
  for (int i = 0; i < 200; ++i) {
    const Mode mode = random_mode(random);
    expect_sharp(symplectic_euler_limit, symplectic_euler_step, mode);
    expect_sharp(symplectic_euler_limit, symplectic_euler_step, {mode.omega_squared, 0.0});
    expect_sharp(symplectic_euler_limit, symplectic_euler_step, {0.0, mode.c});
  }
}

TEST(ModeLimits, Rk4IsSharpOnBothSides) {
  Random random(3);
  for (int i = 0; i < 200; ++i) expect_sharp(rk4_limit, rk4_step, random_mode(random));
}

TEST(ModeLimits, TakeTheKnownValues) {
  EXPECT_NEAR(rk4_limit(1.0, 0.0), 2.0 * std::sqrt(2.0), 1e-12);  // imaginary axis: 2 sqrt 2
  EXPECT_NEAR(rk4_limit(0.0, 1.0), 2.785293563405282, 1e-12);     // real axis
  EXPECT_DOUBLE_EQ(explicit_euler_limit(4.0, 1.0), 0.25);         // c / omega^2
  EXPECT_DOUBLE_EQ(explicit_euler_limit(4.0, 5.0), 0.5);          // roots -1 and -4
  EXPECT_EQ(explicit_euler_limit(4.0, 0.0), 0.0);
  EXPECT_DOUBLE_EQ(leapfrog_limit(4.0, 7.0), 1.0);
  EXPECT_DOUBLE_EQ(symplectic_euler_limit(4.0, 0.0), 1.0);
  EXPECT_DOUBLE_EQ(symplectic_euler_limit(4.0, 3.0), 0.5);  // 4 / (3 + 5)
  EXPECT_DOUBLE_EQ(symplectic_euler_limit(0.0, 4.0), 0.5);
}

TEST(ModeLimits, FreeMotionHasNoneAndGrowingMotionIsNotPredicted) {
  for (Limit limit : {static_cast<Limit>(explicit_euler_limit), symplectic_euler_limit, leapfrog_limit,
                      static_cast<Limit>(rk4_limit)}) {
    EXPECT_EQ(limit(0.0, 0.0), kInfinity);
    EXPECT_TRUE(std::isnan(limit(-1.0, 0.0)));
    EXPECT_TRUE(std::isnan(limit(1.0, -1.0)));
    EXPECT_TRUE(std::isnan(limit(kNaN, 0.0)));
  }
}

TEST(ModeLimits, EveryRayOfTheLeftHalfPlaneLeavesRk4BeyondItsRadius) {
  double least = kInfinity;
  for (int i = 0; i <= 2000; ++i)
    least = std::min(least, rk4_limit({-std::sin(pi * i / 4000.0), std::cos(pi * i / 4000.0)}));
  EXPECT_GE(least, kRk4Radius);
  EXPECT_NEAR(least, kRk4Radius, 1e-3);  // 2.61559
}

// ---- The notes' step on small pencils (notes E8)
// --------------------------------------------------------------------

struct Pencil {
  MatrixXd M, Km, Kg;
};

// Km = J^T D J of rank 3, Kg of either sign with Km + Kg >= 0, in 5 coordinates.
Pencil random_pencil(Random& random) {
  auto matrix = [&](int rows, int columns) -> MatrixXd {
    return random.numbers(rows * columns).reshaped(rows, columns);
  };
  Pencil p;
  p.M = (random.numbers(5).array() + 1.5).matrix().asDiagonal();
  const MatrixXd J = matrix(3, 5), S = matrix(5, 5);
  p.Km = std::pow(10.0, random.uniform(0.0, 3.0)) * J.transpose() * J;
  p.Kg = std::pow(10.0, random.uniform(-1.0, 2.0)) * S.transpose() * S - random.uniform(0.0, 0.5) * p.Km;
  return p;
}

TEST(NotesStepLimit, IsSharpOnTwoHundredRandomPencils) {
  Random random(4);
  for (int i = 0; i < 200; ++i) {
    const auto [M, Km, Kg] = random_pencil(random);
    const MatrixXd none = MatrixXd::Zero(5, 5);
    const double dt = notes_step_limit(M, Km, Kg, none);
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> eigen(Kg - Km, M, Eigen::EigenvaluesOnly);
    EXPECT_NEAR(dt, 2.0 / std::sqrt(eigen.eigenvalues()[4]), 1e-10 * dt);
    EXPECT_LE(spectral_radius(notes_step(M, Km, Kg, none, 0.999 * dt)), 1.0 + 1e-9);
    EXPECT_GT(spectral_radius(notes_step(M, Km, Kg, none, 1.001 * dt)), 1.0);
  }
}

TEST(NotesStepLimit, IsSharpWithDampedRowsAndDrag) {
  Random random(5);
  for (int i = 0; i < 200; ++i) {
    const auto [M, Km, Kg] = random_pencil(random);
    const MatrixXd C = std::pow(10.0, random.uniform(-3.0, 0.0)) * Km + random.uniform(0.0, 5.0) * M;
    const double dt = notes_step_limit(M, Km, Kg, C),
                 undamped = notes_step_limit(M, Km, Kg, MatrixXd::Zero(5, 5));
    EXPECT_GT(dt, undamped);  // damping helps
    EXPECT_LE(spectral_radius(notes_step(M, Km, Kg, C, 0.999 * dt)), 1.0 + 1e-9);
    EXPECT_GT(spectral_radius(notes_step(M, Km, Kg, C, 1.001 * dt)), 1.0);
  }
}

TEST(NotesStepLimit, IsInfiniteWhereKmDominates) {
  Random random(6);
  const MatrixXd J = random.numbers(25).reshaped(5, 5), E = MatrixXd::Identity(5, 5);
  const MatrixXd Km = J.transpose() * J + E;
  EXPECT_EQ(notes_step_limit(E, Km, 0.5 * E, MatrixXd::Zero(5, 5)), kInfinity);
}

// ---- Systems
// ------------------------------------------------------------------------------------------------------------

// n beads between two walls, spring rest length `rest` at spacing 1 m.
TestScene chain(int n, double d, double m, double rest, FreeMask free, double tau = 0.0, double drag = 0.0) {
  SystemBuilder builder;
  std::vector<Anchor> at{builder.add_world_point({0, 0, 0})};
  for (int i = 1; i <= n; ++i) at.push_back(builder.add_particle(m, {1.0 * i, 0, 0}, Vector3d::Zero(), free));
  at.push_back(builder.add_world_point({n + 1.0, 0, 0}));
  for (int i = 0; i <= n; ++i) builder.add_distance(at[i], at[i + 1], {d, tau}, rest);
  builder.set_drag(drag);
  auto [system, state] = builder.build();
  return {std::move(system), std::move(state)};
}

double chain_frequency(int n, double k, double m, int mode) {
  return 2.0 * std::sqrt(k / m) * std::sin(mode * pi / (2.0 * (n + 1)));
}

// M^-1/2 K M^-1/2 and M^-1/2 C M^-1/2 by finite differences of the forces: nothing shared with the code under
// test.
struct Linear {
  MatrixXd K, C;
};
Linear linearise(const System& s, const State& at) {
  std::vector<int> free;
  for (int i = 0; i < 3 * s.nodes; ++i)
    if (s.inverse_mass[i] > 0.0) free.push_back(i);
  auto forces = [&](bool velocity) {
    return [&, velocity](const VectorXd& x) {
      State state = at;
      (velocity ? state.v : state.q)(free) = x;
      VectorXd f;
      EXPECT_TRUE(evaluate_forces(s, state, f).ok());
      return VectorXd(f(free));
    };
  };
  const VectorXd scale = s.inverse_mass(free).cwiseSqrt();
  auto scaled = [&](const MatrixXd& A) { return MatrixXd(-(scale.asDiagonal() * A * scale.asDiagonal())); };
  return {scaled(finite_jacobian(forces(false), at.q(free), 1e-3)),
          scaled(finite_jacobian(forces(true), at.v(free), 1.0))};
}

TEST(LargestFrequency, EqualsTheHighestChainMode) {
  for (int n : {6, 400}) {  // dense and Lanczos
    const auto [system, state] = chain(n, 500.0, 0.2, 1.0, FreeMask{1});
    EXPECT_EQ(n > kLargestDenseSize, system.free_count > kLargestDenseSize);
    const double exact = chain_frequency(n, 500.0, 0.2, n);
    EXPECT_NEAR(largest_frequency(system, state), exact, 1e-9 * exact);
  }
}

TEST(LargestFrequency, CountsTheStressAndTheUserForce) {
  const auto [system, state] = mixed_scene(3, {.rods = false});
  State at_rest = state;
  at_rest.v.setZero();
  const Linear linear = linearise(system, at_rest);
  const double exact = std::sqrt(Eigen::SelfAdjointEigenSolver<MatrixXd>(linear.K).eigenvalues().maxCoeff());
  EXPECT_NEAR(largest_frequency(system, at_rest), exact, 1e-7 * exact);
}

TEST(LargestFrequency, IsNaNWithHardRowsAndAtDegenerateStates) {
  const auto [rods, state] = mixed_scene(3);
  EXPECT_TRUE(std::isnan(largest_frequency(rods, state)));
  EXPECT_NE(stability_limit_leapfrog(rods, state).why.find("distance row"), std::string::npos);
  const auto [system, start] = mixed_scene(3, {.rods = false});
  State bad = start;
  bad.q[6] = kNaN;
  EXPECT_TRUE(std::isnan(largest_frequency(system, bad)));
}

TEST(LargestFrequency, IsZeroForManyParticlesWithoutRows) {
  SystemBuilder builder;
  for (int i = 0; i < kLargestDenseSize; ++i) builder.add_particle(1.0, {1.0 * i, 0, 0});
  const auto [system, state] = builder.build();
  EXPECT_EQ(largest_frequency(system, state), 0.0);
}

TEST(StabilityForecast, EqualsTheLimitsOneByOne) {
  const auto [system, state] = chain(5, 100.0, 0.3, 0.8, kFree, 0.03, 0.2);
  const StabilityForecast all = forecast_stability(
      system, state, {"explicit_euler", "leapfrog", "rk4", "implicit_euler_notes", "implicit_euler_newton"});
  EXPECT_EQ(all.limits[0].dt, stability_limit_explicit_euler(system, state).dt);
  EXPECT_EQ(all.limits[1].dt, stability_limit_leapfrog(system, state).dt);
  EXPECT_EQ(all.limits[2].dt, stability_limit_rk4(system, state).dt);
  EXPECT_EQ(all.limits[3].dt, stability_limit_notes_step(system, state).dt);
  EXPECT_EQ(all.limits[4].dt, kInfinity);
  EXPECT_EQ(all.spectrum.largest_frequency, largest_frequency(system, state));
}

TEST(StabilityForecast, KnowsBothEndsOfTheSpectrumAndTheDamping) {
  const auto [system, state] = chain(5, 100.0, 0.3, 0.8, kFree, 0.03, 0.2);
  const Linear linear = linearise(system, state);
  const VectorXd K = Eigen::SelfAdjointEigenSolver<MatrixXd>(linear.K).eigenvalues();
  const double c = Eigen::SelfAdjointEigenSolver<MatrixXd>(linear.C).eigenvalues().maxCoeff();
  const Spectrum spectrum = forecast_stability(system, state, {}).spectrum;
  EXPECT_NEAR(spectrum.largest_frequency, std::sqrt(K.maxCoeff()), 1e-7 * std::sqrt(K.maxCoeff()));
  EXPECT_NEAR(spectrum.smallest_frequency, std::sqrt(K.minCoeff()), 1e-6 * std::sqrt(K.minCoeff()));
  EXPECT_NEAR(spectrum.largest_damping_rate, c, 1e-7 * c);
}

TEST(StabilityForecast, LeavesHardRowsOut) {
  const auto [with, state] = mixed_scene(3);
  const StabilityForecast forecast = forecast_stability(with, state, {"leapfrog"});
  EXPECT_TRUE(std::isnan(forecast.limits[0].dt));
  EXPECT_NE(forecast.spectrum.left_out.find("is hard"), std::string::npos);
  EXPECT_GT(forecast.spectrum.largest_frequency, 0.0);
}

TEST(StabilityLimit, LeapfrogIsSharpWithUnevenDampingAndStress) {
  const auto [system, state] = chain(5, 100.0, 0.3, 0.8, kFree, 0.03, 0.2);
  const Linear linear = linearise(system, state);
  const double dt = stability_limit_leapfrog(system, state).dt;
  EXPECT_LE(spectral_radius(leapfrog_step(linear.K, linear.C, 0.999 * dt)), 1.0 + 1e-9);
  EXPECT_GT(spectral_radius(leapfrog_step(linear.K, linear.C, 1.001 * dt)), 1.0);
}

using SystemLimit = StabilityLimit (*)(const System&, const State&);
void expect_sharp(SystemLimit limit, Step step, const TestScene& scene) {
  const Linear linear = linearise(scene.system, scene.state);
  const StabilityLimit predicted = limit(scene.system, scene.state);
  ASSERT_TRUE(predicted.dt > 0.0 && std::isfinite(predicted.dt)) << predicted.why;
  EXPECT_LE(spectral_radius(step(linear.K, linear.C, 0.999 * predicted.dt)), 1.0 + 1e-7) << predicted.why;
  EXPECT_GT(spectral_radius(step(linear.K, linear.C, 1.001 * predicted.dt)), 1.0 + 1e-7) << predicted.why;
}

TEST(StabilityLimit, ExplicitEulerIsSharpWhereDampingDiagonalises) {
  expect_sharp(stability_limit_explicit_euler, explicit_euler_step,
               chain(5, 100.0, 0.3, 1.0, FreeMask{1}, 0.03));
  expect_sharp(stability_limit_explicit_euler, explicit_euler_step,
               chain(5, 100.0, 0.3, 1.0, FreeMask{1}, 0.3, 0.2));
  expect_sharp(stability_limit_explicit_euler, explicit_euler_step,
               chain(5, 100.0, 0.3, 0.8, kFree, 0.0, 0.2));
}

TEST(StabilityLimit, ExplicitEulerIsSharpOnTheCompanionMatrix) {
  const TestScene scene = chain(5, 100.0, 0.3, 0.8, kFree, 0.03, 0.2);
  expect_sharp(stability_limit_explicit_euler, explicit_euler_step, scene);
  EXPECT_NE(stability_limit_explicit_euler(scene.system, scene.state).why.find("companion"),
            std::string::npos);
}

TEST(StabilityLimit, Rk4IsSharpInBothCases) {
  expect_sharp(stability_limit_rk4, rk4_step, chain(5, 100.0, 0.3, 1.0, FreeMask{1}));
  expect_sharp(stability_limit_rk4, rk4_step, chain(5, 100.0, 0.3, 1.0, FreeMask{1}, 0.3, 0.2));
  expect_sharp(stability_limit_rk4, rk4_step, chain(5, 100.0, 0.3, 0.8, kFree, 0.03, 0.2));
}

TEST(StabilityLimit, HeavyDragMakesTheSlowestModeDecide) {
  const TestScene scene = chain(5, 100.0, 0.3, 1.0, FreeMask{1}, 0.0, 30.0);
  expect_sharp(stability_limit_explicit_euler, explicit_euler_step, scene);
  EXPECT_NE(stability_limit_explicit_euler(scene.system, scene.state).why.find("slowest"), std::string::npos);
}

TEST(StabilityLimit, ExplicitEulerHasNoStableStepWithoutDamping) {
  const auto [system, state] = chain(5, 100.0, 0.3, 0.8, kFree);
  EXPECT_EQ(stability_limit_explicit_euler(system, state).dt, 0.0);
}

TEST(StabilityLimit, LargeSystemsWithOtherDampingAreNotPredicted) {
  const auto [system, state] = chain(120, 100.0, 0.3, 0.8, kFree, 0.03);
  ASSERT_GT(system.free_count, kLargestDenseSize);
  const StabilityLimit limit = stability_limit_explicit_euler(system, state);
  EXPECT_TRUE(std::isnan(limit.dt));
  EXPECT_NE(limit.why.find("does not diagonalise"), std::string::npos) << limit.why;
}

TEST(StabilityLimit, NotesStepOnATautChainIsTheHighestTransverseMode) {
  for (int n : {20, 150}) {  // dense and Lanczos
    const double d = 1000.0, m = 0.1, rest = 0.8, tension_per_length = d * (1.0 - rest);
    const auto [system, state] = chain(n, d, m, rest, kFree);
    const StabilityLimit limit = stability_limit_notes_step(system, state);
    const double exact = 2.0 / chain_frequency(n, tension_per_length, m, n);
    EXPECT_NEAR(limit.dt, exact, 1e-6 * exact) << limit.why;  // 150 beads: 1e-9
  }
}

TEST(StabilityLimit, NotesStepHasNoneOnAnUnstressedOrCompressedChain) {
  for (double rest : {1.0, 1.05}) {
    const auto [system, state] = chain(20, 1000.0, 0.1, rest, kFree);
    const StabilityLimit limit = stability_limit_notes_step(system, state);
    EXPECT_EQ(limit.dt, kInfinity) << limit.why;
  }
}

TEST(StabilityLimit, NotesStepCountsDragAndDampedRows) {
  const TestScene scene = chain(6, 100.0, 0.3, 0.6, kFree, 0.02, 0.5);
  const Linear linear = linearise(scene.system, scene.state);
  const TestScene slack = chain(6, 100.0, 0.3, 1.0, kFree);
  const MatrixXd Km = linearise(slack.system, slack.state).K, E = MatrixXd::Identity(Km.rows(), Km.cols());
  const double dt = stability_limit_notes_step(scene.system, scene.state).dt;
  EXPECT_LE(spectral_radius(notes_step(E, Km, linear.K - Km, linear.C, 0.999 * dt)), 1.0 + 1e-7);
  EXPECT_GT(spectral_radius(notes_step(E, Km, linear.K - Km, linear.C, 1.001 * dt)), 1.0 + 1e-7);
}

StabilityLimit symplectic_limit(const System& system, const State& state) {
  return stability_limit("symplectic_euler", system, state);
}

TEST(StabilityLimit, SymplecticEulerIsSharpWithAnyDamping) {
  expect_sharp(symplectic_limit, symplectic_euler_step, chain(5, 100.0, 0.3, 1.0, FreeMask{1}));
  expect_sharp(symplectic_limit, symplectic_euler_step, chain(5, 100.0, 0.3, 0.8, kFree, 0.0, 0.2));
  expect_sharp(symplectic_limit, symplectic_euler_step, chain(5, 100.0, 0.3, 1.0, FreeMask{1}, 0.3, 0.2));
  expect_sharp(symplectic_limit, symplectic_euler_step, chain(5, 100.0, 0.3, 0.8, kFree, 0.03, 0.2));
  expect_sharp(symplectic_limit, symplectic_euler_step, chain(5, 100.0, 0.3, 1.0, FreeMask{1}, 0.0, 30.0));
  expect_sharp(symplectic_limit, symplectic_euler_step, chain(120, 100.0, 0.3, 0.8, kFree, 0.03));
}

// A pair on a spring, and a light particle that nothing but its drag (or damper) holds: no mode of K.
TestScene pair_and_loner(double stiffness, double drag, double damper) {
  SystemBuilder builder;
  const Anchor a = builder.add_particle(1.0, {0, 0, 0}), b = builder.add_particle(1.0, {1, 0, 0}),
               loner = builder.add_particle(0.01, {3, 0, 0});
  builder.add_distance(a, b, {stiffness, 0.0});
  if (damper > 0.0) builder.add_distance(b, loner, {0.0, 0.0, damper});
  builder.set_drag(drag);
  auto [system, state] = builder.build();
  return {std::move(system), std::move(state)};
}

TEST(StabilityLimit, SymplecticEulerSeesDampingWhereThereIsNoStiffness) {
  expect_sharp(symplectic_limit, symplectic_euler_step, pair_and_loner(10.0, 2.0, 0.0));
  expect_sharp(symplectic_limit, symplectic_euler_step, pair_and_loner(10.0, 0.0, 2.0));
  expect_sharp(symplectic_limit, symplectic_euler_step, pair_and_loner(0.0, 0.0, 2.0));
  expect_sharp(symplectic_limit, symplectic_euler_step, pair_and_loner(0.0, 2.0, 0.0));
  // damping so strong that x.Kx is rounding of (x.Cx)^2
  expect_sharp(symplectic_limit, symplectic_euler_step, pair_and_loner(1e-9, 2e3, 0.0));
  EXPECT_NEAR(
      symplectic_limit(pair_and_loner(10.0, 2.0, 0.0).system, pair_and_loner(10.0, 2.0, 0.0).state).dt, 0.01,
      1e-12);  // 2 m / drag
}

// The integrator itself, pushed out of rest: |v| over many steps.
TEST(StabilityLimit, SymplecticEulerDecaysBelowAndGrowsBeyondIt) {
  for (const TestScene& scene :
       {chain(5, 100.0, 0.3, 1.0, FreeMask{1}, 0.03), chain(5, 100.0, 0.3, 1.0, FreeMask{1}, 0.0, 0.5),
        chain(5, 100.0, 0.3, 0.8, kFree, 0.02, 0.2), pair_and_loner(10.0, 2.0, 0.0)}) {
    const double limit = symplectic_limit(scene.system, scene.state).dt;
    auto grown = [&](double dt) {
      State state = scene.state;
      Random random(8);
      for (int i = 0; i < state.v.size(); ++i)
        if (scene.system.inverse_mass[i] > 0.0) state.v[i] = 1e-9 * random.uniform(-1.0, 1.0);
      SymplecticEuler method(scene.system, {});
      History history;
      EXPECT_TRUE(method.prepare().ok());
      const double start = state.v.norm();
      bool ok = true;
      for (int n = 0; n < 1500 && ok; ++n) ok = method.step(dt, state, history, nullptr).ok();
      EXPECT_TRUE(ok);
      return state.v.norm() / start;
    };
    EXPECT_LT(grown(0.99 * limit), 1e-2);  // 1.0e-4 at most
    EXPECT_GT(grown(1.01 * limit), 1e6);   // 1.2e9 at least
  }
}

TEST(LargestRate, BoundsEveryRootOfADampedScene) {
  for (std::uint64_t seed : {1, 2, 3, 4}) {
    auto [system, state] = mixed_scene(seed, {.rods = false, .user_force = false});
    state.v.setZero();
    const Linear linear = linearise(system, state);
    const double largest = Eigen::EigenSolver<MatrixXd>(first_order(linear.K, linear.C), false)
                               .eigenvalues()
                               .cwiseAbs()
                               .maxCoeff();
    const double bound = largest_rate(system, state);
    EXPECT_GE(bound, largest * (1.0 - 1e-7));
    EXPECT_LE(bound, 2.0 * largest);
  }
}

}  // namespace
}  // namespace feder
