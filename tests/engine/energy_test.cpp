#include "engine/energy.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "engine/kkt.h"
#include "tests/support/finite_difference.h"
#include "tests/support/scenes.h"

namespace feder {
namespace {

/// Two particles on the x axis, 3 m apart, on a spring of rest length 2 m; a world point with a second
/// spring.
TestScene two_masses() {
  SystemBuilder builder;
  const Anchor a = builder.add_particle(2.0, {0, 0, 0}, {1, 2, 3}),
               b = builder.add_particle(0.5, {3, 0, 0}, {0, -4, 0});
  const Anchor wall = builder.add_world_point({3, 1, 0});
  builder.add_distance(a, b, {10.0}, 2.0);
  builder.add_distance(b, wall, {4.0}, 0.5);
  builder.add_distance(a, wall, {kRigid}, 1.0);  // violated, but a rod stores nothing
  builder.set_gravity({0, -10, 0});
  builder.add_constant_force(b, {0, 0, 7});
  auto [system, state] = builder.build();
  state.q[8] = 0.0;
  return {std::move(system), std::move(state)};
}

TEST(Energy, KineticIsHalfMassTimesSpeedSquared) {
  const TestScene scene = two_masses();
  EXPECT_DOUBLE_EQ(kinetic_energy(scene.system, scene.state), 0.5 * 2.0 * 14.0 + 0.5 * 0.5 * 16.0);
}

TEST(Energy, RowEnergyIsHalfStiffnessTimesStretchSquaredOverTheFiniteRows) {
  const TestScene scene = two_masses();
  EXPECT_DOUBLE_EQ(row_energy(scene.system, scene.state), 0.5 * 10.0 * 1.0 + 0.5 * 4.0 * 0.25);
}

TEST(Energy, ExternalEnergyIsMinusForceTimesPosition) {
  TestScene scene = two_masses();
  scene.state.q.segment<3>(0) = Vector3d(1, 5, 0);
  scene.state.q.segment<3>(3) = Vector3d(2, 3, -4);
  // m g y, and -7 z for the constant force
  EXPECT_DOUBLE_EQ(external_energy(scene.system, scene.state),
                   2.0 * 10.0 * 5.0 + 0.5 * 10.0 * 3.0 + 7.0 * 4.0);
}

TEST(Energy, ExternalEnergyIncludesTheUsersPotential) {
  const TestScene scene = mixed_scene(1);
  TestScene without = mixed_scene(1, {.user_force = false});
  const double potential = scene.system.forces.user.potential(0.0, scene.state.q);
  ASSERT_GT(potential, 1.0);
  EXPECT_NEAR(external_energy(scene.system, scene.state) - external_energy(without.system, without.state),
              potential, 1e-11);  // 0
}

TEST(Energy, BendingRowsStoreEnergyOfTheirAngle) {
  SystemBuilder builder;
  for (const Vector3d& x : {Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(1, 1, 0)})
    builder.add_particle(1.0, x);
  builder.add(CurvatureRow{{0, 1, 2}, 3.0, 0.0});  // kappa = 2 tan(45 degrees) = 2
  builder.add(AngleRow{{0, 1, 2}, 5.0, 0.0, 1.0});
  const auto [system, state] = builder.build();
  const double psi = 0.5 * 3.14159265358979323846 - 1.0;
  EXPECT_NEAR(row_energy(system, state), 0.5 * 3.0 * 4.0 + 0.5 * 5.0 * psi * psi, 1e-14);  // 0
}

TEST(Energy, TotalIsTheSumOfTheThree) {
  const TestScene scene = mixed_scene(2);
  EXPECT_DOUBLE_EQ(total_energy(scene.system, scene.state), kinetic_energy(scene.system, scene.state) +
                                                                row_energy(scene.system, scene.state) +
                                                                external_energy(scene.system, scene.state));
}

TEST(Energy, ForcesAreMinusItsGradient) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const TestScene scene = mixed_scene(seed, {.damping = false});
    const System& s = scene.system;
    auto potential = [&](const VectorXd& q) {
      const State at{scene.state.t, q, scene.state.v};
      return row_energy(s, at) + external_energy(s, at);
    };
    VectorXd force, gradient = finite_gradient(potential, scene.state.q, 1e-3);
    ASSERT_TRUE(evaluate_forces(s, scene.state, force).ok());
    for (int i : s.masked) force[i] = gradient[i] = 0.0;
    ASSERT_GT(force.norm(), 10.0);
    EXPECT_LT((force + gradient).norm(), 1e-7 * force.norm()) << seed;  // 8e-12
  }
}

TEST(Energy, RowForcesAreMinusTheGradientOfTheRowEnergyAlsoWhereCoordinatesAreMasked) {
  const TestScene scene = mixed_scene(3, {.damping = false, .user_force = false});
  const System& s = scene.system;
  auto energy = [&](const VectorXd& q) { return row_energy(s, State{0.0, q, scene.state.v}); };
  VectorXd force;
  ASSERT_TRUE(evaluate_undamped_forces(s, scene.state, force).ok());
  force -= s.forces.constant;
  double masked = 0.0;
  for (int i : s.masked) masked += std::abs(force[i]);
  ASSERT_GT(masked, 1.0);
  EXPECT_LT((force + finite_gradient(energy, scene.state.q, 1e-3)).norm(), 1e-7 * force.norm());  // 2e-12
}

TEST(Momentum, LinearIsTheSumOfMassTimesVelocity) {
  const TestScene scene = two_masses();
  EXPECT_TRUE(linear_momentum(scene.system, scene.state).isApprox(Vector3d(2.0, 4.0 - 2.0, 6.0), 1e-15));
}

TEST(Momentum, AngularIsTheSumOfPositionCrossMomentum) {
  const TestScene scene = two_masses();
  // a sits at the origin; b: (3, 0, 0) x 0.5 (0, -4, 0)
  EXPECT_TRUE(angular_momentum(scene.system, scene.state).isApprox(Vector3d(0.0, 0.0, -6.0), 1e-15));
}

/// A free net without world points or masks; `curvature` adds bent curvature rows.
TestScene free_net(bool damping, bool curvature) {
  Random random(21);
  SystemBuilder builder;
  for (int i = 0; i < 8; ++i)
    builder.add_particle(random.uniform(0.2, 2.0), Vector3d(i, i % 2, i % 3) + random.vector(0.2),
                         random.vector());
  for (int i = 0; i < 7; ++i)
    builder.add_distance({i}, {i + 1}, {random.uniform(5.0, 50.0), damping ? 0.1 : 0.0}, 1.0);
  builder.add_distance({0}, {5}, {3.0, damping ? 0.2 : 0.0}, 2.0);
  builder.add(AngleRow{{1, 2, 3}, 6.0, damping ? 0.1 : 0.0, 0.4});
  if (curvature) builder.add(CurvatureRow{{4, 5, 6}, 2.0, 0.0});
  auto [system, state] = builder.build();
  return {std::move(system), std::move(state)};
}

void sum_up(const TestScene& scene, Vector3d& force, Vector3d& torque, double& size) {
  VectorXd f;
  ASSERT_TRUE(evaluate_forces(scene.system, scene.state, f).ok());
  force = torque = Vector3d::Zero();
  size = f.norm();
  for (int i = 0; i < scene.system.nodes; ++i) {
    const Vector3d at = f.segment<3>(3 * i);
    force += at;
    torque += Vector3d(scene.state.q.segment<3>(3 * i)).cross(at);
  }
}

TEST(Momentum, RowForcesChangeNeitherMomentum) {
  Vector3d force, torque;
  double size = 0.0;
  sum_up(free_net(false, true), force, torque, size);
  ASSERT_GT(size, 10.0);
  EXPECT_LT(force.norm(), 1e-14 * size);   // 3e-17
  EXPECT_LT(torque.norm(), 1e-13 * size);  // 3e-16
}

TEST(Momentum, RowDampingOfLengthsAndAnglesChangesNeitherMomentum) {
  Vector3d force, torque;
  double size = 0.0, undamped = 0.0;
  sum_up(free_net(false, false), force, torque, undamped);
  sum_up(free_net(true, false), force, torque, size);
  ASSERT_GT(std::abs(size - undamped), 0.01 * size);
  EXPECT_LT(force.norm(), 1e-14 * size);   // 8e-17
  EXPECT_LT(torque.norm(), 1e-13 * size);  // 4e-16
}

TEST(EnergyLedger, ImbalanceIsTheKineticChangeMinusItsSources) {
  EnergyLedger ledger{10.0, -3.0, 4.0, -1.0, 6.0, -2.0, -0.5};
  EXPECT_DOUBLE_EQ(ledger.imbalance(), 10.0 - (4.0 - 1.0 + 6.0 - 2.0 - 0.5));
  EXPECT_DOUBLE_EQ(ledger.magnitude(), 10.0 + 3.0 + 4.0 + 1.0 + 6.0 + 2.0 + 0.5);
  EXPECT_DOUBLE_EQ(ledger.energy_change(), 7.0);
}

}  // namespace
}  // namespace feder
