// phi, J, gamma and forces of Kkt against definitions written a second time (tests/support/dense_kkt.h).
#include "engine/kkt.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "engine/energy.h"
#include "tests/support/allocations.h"
#include "tests/support/dense_kkt.h"
#include "tests/support/finite_difference.h"
#include "tests/support/kernel_choice.h"
#include "tests/support/scenes.h"

namespace feder {
namespace {

Kkt evaluated(const TestScene& scene, double sigma = 0.01, double rho = 0.1) {
  Kkt kkt;
  kkt.prepare(scene.system);
  kkt.set_step(sigma, rho);
  const Status status = kkt.evaluate(scene.state.q);
  EXPECT_TRUE(status.ok()) << status.reason;
  return kkt;
}

Eigen::MatrixXd jacobian_by_columns(const Kkt& kkt) {
  const System& s = *kkt.system;
  Eigen::MatrixXd J(s.rows, 3 * s.nodes);
  VectorXd column;
  for (int c = 0; c < 3 * s.nodes; ++c) {
    kkt.multiply_jacobian(VectorXd::Unit(3 * s.nodes, c), column);
    J.col(c) = column;
  }
  return J;
}

double largest(const Eigen::MatrixXd& m) {
  return m.cwiseAbs().maxCoeff();
}

TEST(Kkt, PhiAndJacobianAreTheDefinitions) {
  for (const std::string& name : kernel_names()) {
    const KernelChoice choice(name);
    if (!choice.available()) continue;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const TestScene scene = mixed_scene(seed, {.hard_angle = true});
      Kkt kkt = evaluated(scene);
      const DenseRows dense = dense_rows(scene.system, scene.state.q);
      ASSERT_GT(largest(dense.phi), 0.5);
      ASSERT_GT(largest(dense.jacobian), 0.5);
      EXPECT_LT(largest(kkt.phi - dense.phi), 2e-13);  // 2e-14, a sharply bent curvature row
      EXPECT_LT(largest(jacobian_by_columns(kkt) - dense.jacobian), 1e-12) << name;  // 6e-14
    }
  }
}

TEST(Kkt, JacobianAgreesWithDifferencesOfPhi) {
  const TestScene scene = mixed_scene(5, {.hard_angle = true});
  Kkt kkt = evaluated(scene);
  auto phi = [&](const VectorXd& q) {
    VectorXd out;
    evaluate_phi(scene.system, q, out);
    for (int k = 0; k < out.size(); ++k)  // the element without stiffness has phi, but no row in this step
      if (scene.system.stiffness[k] == 0.0) out[k] = 0.0;
    return out;
  };
  const Eigen::MatrixXd F = finite_jacobian(phi, scene.state.q, 1e-3), J = jacobian_by_columns(kkt);
  ASSERT_GT(largest(J), 0.5);
  EXPECT_LT(largest(J - F), 1e-9);  // 2e-10
}

TEST(Kkt, EvaluatePhiAgreesWithEvaluate) {
  const TestScene scene = mixed_scene(6, {.hard_angle = true});
  Kkt kkt = evaluated(scene);
  VectorXd phi;
  evaluate_phi(scene.system, scene.state.q, phi);
  ASSERT_GT(phi.norm(), 1.0);
  for (int k = 0; k < phi.size(); ++k)
    if (scene.system.stiffness[k] > 0.0) {
      EXPECT_NEAR(phi[k], kkt.phi[k], 1e-15) << scene.system.row_name(k);  // 0
    }
}

TEST(Kkt, TransposeIsTheAdjointOfJ) {
  Random random(3);
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const TestScene scene = mixed_scene(seed, {.hard_angle = true});
    Kkt kkt = evaluated(scene);
    const VectorXd v = random.numbers(3 * scene.system.nodes), y = random.numbers(scene.system.rows);
    VectorXd Jv, Jty = VectorXd::Zero(v.size());
    kkt.multiply_jacobian(v, Jv);
    kkt.add_jacobian_transpose(y, Jty);
    ASSERT_GT(Jv.norm() * y.norm(), 1.0);
    EXPECT_LT(std::abs(y.dot(Jv) - v.dot(Jty)), 1e-14 * Jv.norm() * y.norm());  // 1e-16
  }
}

TEST(Kkt, TransposeAddsToWhatIsThere) {
  const TestScene scene = mixed_scene(2);
  Kkt kkt = evaluated(scene);
  const VectorXd y = VectorXd::Ones(scene.system.rows);
  VectorXd once = VectorXd::Zero(36), onto = VectorXd::Constant(36, 2.0);
  kkt.add_jacobian_transpose(y, once);
  kkt.add_jacobian_transpose(y, onto);
  ASSERT_GT(once.norm(), 1.0);
  EXPECT_LT(largest(onto - once - VectorXd::Constant(36, 2.0)), 1e-14);  // 1e-15
}

TEST(Kkt, SwitchedOffRowsHaveNoPhiAndNoJacobian) {
  const TestScene scene = mixed_scene(3);
  Kkt kkt = evaluated(scene);
  const Eigen::MatrixXd J = jacobian_by_columns(kkt);
  int found = 0;
  for (int k = 0; k < scene.system.rows; ++k) {
    if (scene.system.stiffness[k] > 0.0) {
      EXPECT_GT(J.row(k).norm(), 0.05) << scene.system.row_name(k);
      continue;
    }
    ++found;
    EXPECT_EQ(kkt.phi[k], 0.0);
    EXPECT_TRUE(J.row(k).isZero(0.0));
    EXPECT_EQ(kkt.gamma[k], 1.0);
    EXPECT_EQ(kkt.inverse_gamma[k], 0.0);
  }
  EXPECT_GE(found, 2);
}

/// A spring, a rod, a damped spring, a spring of stiffness 0 with damping time, a curvature and a damped
/// angle, in this order.
TestScene one_of_each() {
  SystemBuilder builder;
  for (int i = 0; i < 4; ++i) builder.add_particle(1.0, {1.0 * i, 0.3 * (i % 2), 0.2 * i * i});
  builder.add_distance({0}, {1}, {50.0}, 1.0);
  builder.add_distance({1}, {2}, {kRigid});
  builder.add_distance({2}, {3}, {20.0, 0.25}, 1.0);
  builder.add_distance({0}, {3}, {0.0, 0.25}, 1.0);
  builder.add(CurvatureRow{{0, 1, 2}, 8.0, 0.0});
  builder.add(AngleRow{{1, 2, 3}, 4.0, 0.5, 1.0});
  builder.add(AngleRow{{0, 2, 3}, kRigid, 0.0, 1.0});
  builder.add_distance({1}, {3}, {kRigid, 0.1});
  auto [system, state] = builder.build();
  return {std::move(system), std::move(state)};
}

TEST(Kkt, GammaIsOneOverSigmaDPlusRhoB) {
  const TestScene scene = one_of_each();
  const double sigma = 0.01, rho = 0.1;
  Kkt kkt = evaluated(scene, sigma, rho);
  const auto& row = scene.system.row_of_id;
  EXPECT_DOUBLE_EQ(kkt.gamma[row[0]], 1.0 / (sigma * 50.0));
  EXPECT_DOUBLE_EQ(kkt.gamma[row[2]], 1.0 / (sigma * 20.0 + rho * 20.0 * 0.25));
  for (int i = 0; i < 3; ++i) EXPECT_DOUBLE_EQ(kkt.gamma[row[4] + i], 1.0 / (sigma * 8.0));
  EXPECT_DOUBLE_EQ(kkt.gamma[row[5]], 1.0 / (sigma * 4.0 + rho * 4.0 * 0.5));
  for (int id : {0, 2, 4, 5}) EXPECT_DOUBLE_EQ(kkt.gamma[row[id]] * kkt.inverse_gamma[row[id]], 1.0);
}

TEST(Kkt, GammaOfARigidRowIsExactlyZero) {
  const TestScene scene = one_of_each();
  Kkt kkt = evaluated(scene);
  for (int id : {1, 6, 7}) {
    EXPECT_EQ(kkt.gamma[scene.system.row_of_id[id]], 0.0);
    EXPECT_EQ(kkt.inverse_gamma[scene.system.row_of_id[id]], 0.0);
  }
  const Eigen::MatrixXd J = jacobian_by_columns(kkt);
  for (int id : {1, 6, 7}) EXPECT_GT(J.row(scene.system.row_of_id[id]).norm(), 0.1);
}

TEST(Kkt, WithSigmaZeroOnlyDampingPushes) {
  // leapfrog's second kick: sigma = 0, rho = dt/2
  const TestScene scene = one_of_each();
  Kkt kkt = evaluated(scene, 0.0, 0.05);
  const auto& row = scene.system.row_of_id;
  const Eigen::MatrixXd J = jacobian_by_columns(kkt);
  EXPECT_DOUBLE_EQ(kkt.gamma[row[2]], 1.0 / (0.05 * 20.0 * 0.25));
  EXPECT_DOUBLE_EQ(kkt.gamma[row[5]], 1.0 / (0.05 * 4.0 * 0.5));
  EXPECT_GT(J.row(row[2]).norm(), 1.0);
  EXPECT_GT(J.row(row[5]).norm(), 0.1);
  for (int k : {row[0], row[3], row[4], row[4] + 1, row[4] + 2}) {
    EXPECT_EQ(kkt.gamma[k], 1.0);
    EXPECT_EQ(kkt.inverse_gamma[k], 0.0);
    EXPECT_EQ(kkt.phi[k], 0.0);
    EXPECT_TRUE(J.row(k).isZero(0.0));
  }
}

TEST(Kkt, RigidRowsStayRigidWithSigmaZero) {
  const TestScene scene = one_of_each();
  for (double rho : {0.0, 0.05}) {
    Kkt kkt = evaluated(scene, 0.0, rho);
    const Eigen::MatrixXd J = jacobian_by_columns(kkt);
    for (int id : {1, 6, 7}) {
      EXPECT_EQ(kkt.gamma[scene.system.row_of_id[id]], 0.0) << id;
      EXPECT_GT(J.row(scene.system.row_of_id[id]).norm(), 0.1) << id;
    }
  }
}

TEST(Kkt, RowsComeBackWhenSigmaDoes) {
  const TestScene scene = mixed_scene(4);
  Kkt kkt = evaluated(scene, 0.0, 0.05);
  const Eigen::MatrixXd damped = jacobian_by_columns(kkt);
  kkt.set_step(0.01, 0.1);
  ASSERT_TRUE(kkt.evaluate(scene.state.q).ok());
  const Kkt fresh = evaluated(scene, 0.01, 0.1);
  EXPECT_GT((jacobian_by_columns(kkt) - damped).norm(), 1.0);
  EXPECT_TRUE(jacobian_by_columns(kkt) == jacobian_by_columns(fresh));
  EXPECT_TRUE(kkt.gamma == fresh.gamma);
  EXPECT_TRUE(kkt.phi == fresh.phi);
}

TEST(Kkt, MassIsInertiaPlusRhoDrag) {
  const TestScene scene = mixed_scene(1);
  const System& s = scene.system;
  Kkt kkt = evaluated(scene, 0.01, 0.1);
  for (int i = 0; i < 3 * s.nodes; ++i) {
    const double drag = s.inverse_mass[i] > 0.0 ? 0.1 * 0.4 : 0.0;
    EXPECT_DOUBLE_EQ(kkt.mass[i], s.mass[i / 3] + drag);
    EXPECT_DOUBLE_EQ(kkt.inverse_mass[i], s.inverse_mass[i] > 0.0 ? 1.0 / kkt.mass[i] : 0.0);
  }
}

TEST(Kkt, RowsTakenOutAreEmptyAndComeBackAsTheyWere) {
  const TestScene scene = mixed_scene(4, {.hard_angle = true});
  const System& s = scene.system;
  std::vector<int> hard;
  for (int k = 0; k < s.rows; ++k)
    if (std::isinf(s.stiffness[k])) hard.push_back(k);
  ASSERT_GE(hard.size(), 2u);
  Kkt kkt = evaluated(scene);
  kkt.r = VectorXd::Ones(s.rows);
  const Eigen::MatrixXd J = jacobian_by_columns(kkt);
  const VectorXd phi = kkt.phi;
  auto expect_without = [&](int out) {
    const Eigen::MatrixXd now = jacobian_by_columns(kkt);
    for (int k : hard) {
      EXPECT_EQ(kkt.gamma[k], k == out ? 1.0 : 0.0);
      EXPECT_EQ(kkt.phi[k], k == out ? 0.0 : phi[k]);
      EXPECT_EQ(largest(now.row(k) - (k == out ? 0.0 : 1.0) * J.row(k)), 0.0);
    }
    if (out >= 0) {
      EXPECT_EQ(kkt.r[out], 0.0);
    }
  };
  kkt.drop_rows({hard[0]});
  expect_without(hard[0]);
  kkt.drop_rows({hard[1]});  // the first comes back
  expect_without(hard[1]);
  kkt.drop_rows({});
  expect_without(-1);
}

TEST(Kkt, StepSerialChangesWithTheStepAndOnlyThen) {
  const TestScene scene = mixed_scene(1);
  Kkt kkt = evaluated(scene, 0.01, 0.1);
  const long before = kkt.step_serial();
  kkt.set_step(0.01, 0.1);
  EXPECT_EQ(kkt.step_serial(), before);
  kkt.set_step(0.01, 0.2);
  EXPECT_NE(kkt.step_serial(), before);
}

TEST(Forces, AreExternalMinusDragPlusTransposeTimesLambda) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const TestScene scene = mixed_scene(seed);
    const System& s = scene.system;
    const DenseRows rows = dense_rows(s, scene.state.q);
    VectorXd lambda = VectorXd::Zero(s.rows), expected, forces, undamped;
    for (int k = 0; k < s.rows; ++k)
      if (std::isfinite(s.stiffness[k]))
        lambda[k] =
            -s.stiffness[k] * (rows.phi[k] + s.damping_time[k] * rows.jacobian.row(k).dot(scene.state.v));
    evaluate_external_forces(s, scene.state, expected);
    expected += rows.jacobian.transpose() * lambda - s.forces.drag.cwiseProduct(scene.state.v);
    ASSERT_TRUE(evaluate_forces(s, scene.state, forces).ok());
    ASSERT_TRUE(evaluate_undamped_forces(s, scene.state, undamped).ok());
    ASSERT_GT((forces - undamped).norm(), 0.1);
    ASSERT_GT(forces.norm(), 10.0);
    EXPECT_LT((forces - expected).norm(), 1e-13 * forces.norm());  // 7e-15
  }
}

TEST(Forces, ExternalOnesAreZeroWhereMasked) {
  TestScene scene = mixed_scene(1, {.user_force = false});
  scene.system.forces.user =
      quartic_bond(0, 7, 1.0);  // pulls at the world point and at the bead in the plane
  VectorXd f;
  evaluate_external_forces(scene.system, scene.state, f);
  EXPECT_GT(f.norm(), 10.0);
  for (int i : scene.system.masked) EXPECT_EQ(f[i], 0.0);
}

TEST(Forces, RigidRowsPullNothing) {
  // evaluate_forces knows only the finite rows: a rod and a rigid angle leave it as it is
  const TestScene without = mixed_scene(1, {.rods = false}),
              with = mixed_scene(1, {.rods = true, .hard_angle = true});
  VectorXd f, g;
  ASSERT_TRUE(evaluate_forces(without.system, without.state, f).ok());
  ASSERT_TRUE(evaluate_forces(with.system, with.state, g).ok());
  ASSERT_GT(f.norm(), 10.0);
  EXPECT_TRUE(g.allFinite());
  EXPECT_LT((f - g).norm(), 1e-13 * f.norm());  // 0
}

TEST(Forces, AgreeOnEveryKernel) {
  const TestScene scene = mixed_scene(8);
  VectorXd reference;
  {
    const KernelChoice choice("scalar");
    ASSERT_TRUE(evaluate_forces(scene.system, scene.state, reference).ok());
  }
  ASSERT_GT(reference.norm(), 10.0);
  for (const std::string& name : kernel_names()) {
    const KernelChoice choice(name);
    if (!choice.available()) continue;
    VectorXd forces;
    ASSERT_TRUE(evaluate_forces(scene.system, scene.state, forces).ok());
    EXPECT_LT((forces - reference).norm(), 1e-14 * reference.norm()) << name;  // 6e-17
  }
}

TEST(ZeroRestLength, ForceIsThatOfHalfStiffnessTimesDistanceSquared) {
  for (double length : {2.0, 1e-3, 1e-12, 0.0}) {
    SystemBuilder builder;
    builder.add_particle(1.0, {0, 0, 0});
    builder.add_particle(1.0, Vector3d(1, 2, -2) * (length / 3.0));
    builder.add_distance({0}, {1}, {7.0}, 0.0);
    const auto [system, state] = builder.build();
    VectorXd f, expected(6);
    ASSERT_TRUE(evaluate_forces(system, state, f).ok()) << length;
    expected << 7.0 * state.q.tail<3>(), -7.0 * state.q.tail<3>();
    EXPECT_LT((f - expected).norm(), 1e-15 * expected.norm() + 1e-300) << length;  // 0
    EXPECT_NEAR(row_energy(system, state), 3.5 * length * length, 1e-15);          // 0
  }
}

TEST(Kkt, RefillDoesNotAllocate) {
  const TestScene scene = mixed_scene(1, {.hard_angle = true, .user_force = false});
  const System& s = scene.system;
  long before = allocations();
  Kkt kkt;
  kkt.prepare(s);
  EXPECT_GT(allocations() - before, 10);  // 19: the counter sees what the engine asks for
  Random random(1);
  const VectorXd v = random.numbers(3 * s.nodes), y = random.numbers(s.rows), lambda = random.numbers(s.rows);
  kkt.p = random.numbers(3 * s.nodes);
  kkt.r = random.numbers(s.rows);
  VectorXd residual_v, residual_y, Jv, forces;
  bool good = true;
  double size = 0.0;
  auto everything = [&](double dt) {
    kkt.set_step(dt * dt, dt);
    good = kkt.evaluate(scene.state.q).ok() && good;
    for (GeometricStiffness kind : {GeometricStiffness::kFull, GeometricStiffness::kClamped}) {
      kkt.set_geometric_stiffness(kind, dt * dt, scene.state, lambda);
      size += kkt.residual(v, y, &residual_v, &residual_y).backward_error +
              kkt.residual_size(v, y).backward_error;
    }
    kkt.multiply_jacobian(v, Jv);
    kkt.add_jacobian_transpose(y, residual_v);
    good = evaluate_undamped_forces(s, scene.state, forces).ok() && good;
  };
  everything(0.1);
  kkt.set_step(0.0, 0.1);  // the longest list of rows that cannot push
  before = allocations();
  for (int i = 1; i <= 20; ++i) everything(0.01 * i);
  kkt.set_step(0.0, 0.1);
  EXPECT_EQ(allocations() - before, 0);
  EXPECT_TRUE(good);
  EXPECT_GT(size, 0.0);
}

}  // namespace
}  // namespace feder
