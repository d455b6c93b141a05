// Kg = -sum lambda Hess phi: full against the Hessian of the energy, clamped against the positive part of
// each block.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "engine/energy.h"
#include "engine/kkt.h"
#include "tests/support/dense_kkt.h"
#include "tests/support/finite_difference.h"
#include "tests/support/scenes.h"

namespace feder {
namespace {

using Eigen::MatrixXd;

double largest(const MatrixXd& m) {
  return m.cwiseAbs().maxCoeff();
}

MatrixXd geometric_by_columns(const Kkt& kkt) {
  const int n = 3 * kkt.system->nodes;
  MatrixXd K(n, n);
  for (int c = 0; c < n; ++c) {
    VectorXd column = VectorXd::Zero(n);
    kkt.add_geometric(VectorXd::Unit(n, c), column);
    K.col(c) = column;
  }
  return K;
}

Kkt with_geometric(const System& s, const State& state, GeometricStiffness kind, double sigma,
                   const VectorXd& lambda) {
  Kkt kkt;
  kkt.prepare(s);
  kkt.set_step(sigma, std::sqrt(sigma));
  const Status status = kkt.evaluate(state.q);
  EXPECT_TRUE(status.ok()) << status.reason;
  kkt.set_geometric_stiffness(kind, sigma, state, lambda);
  return kkt;
}

VectorXd spring_lambda(const System& s, const VectorXd& q) {
  VectorXd phi, lambda = VectorXd::Zero(s.rows);
  evaluate_phi(s, q, phi);
  for (int k = 0; k < s.rows; ++k)
    if (std::isfinite(s.stiffness[k])) lambda[k] = -s.stiffness[k] * phi[k];
  return lambda;
}

/// The part of a symmetric matrix with eigenvalues >= 0.
MatrixXd positive_part(const MatrixXd& m) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(0.5 * (m + m.transpose()));
  MatrixXd part = MatrixXd::Zero(m.rows(), m.cols());
  for (int i = 0; i < m.rows(); ++i)
    if (eigen.eigenvalues()[i] > 0.0)
      part += eigen.eigenvalues()[i] * eigen.eigenvectors().col(i) * eigen.eigenvectors().col(i).transpose();
  return part;
}

double least_eigenvalue(const MatrixXd& m) {
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(m, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

/// Systems of a single row (or the user force alone), named.
struct Single {
  const char* name;
  TestScene scene;
};

std::vector<Single> single_rows() {
  std::vector<Single> out;
  auto add = [&](const char* name, auto&& row) {
    SystemBuilder builder;
    builder.add_particle(1.0, {0.1, 0.0, -0.2});
    builder.add_particle(2.0, {1.3, 0.4, 0.1});
    builder.add_particle(0.5, {1.8, 1.5, -0.3});
    row(builder);
    auto [system, state] = builder.build();
    out.push_back({name, {std::move(system), std::move(state)}});
  };
  add("stretched spring", [](SystemBuilder& b) { b.add_distance({0}, {1}, {30.0}, 0.7); });
  add("compressed spring", [](SystemBuilder& b) { b.add_distance({0}, {1}, {30.0}, 2.0); });
  add("spring of rest length 0", [](SystemBuilder& b) { b.add_distance({0}, {1}, {30.0}, 0.0); });
  add("curvature", [](SystemBuilder& b) { b.add(CurvatureRow{{0, 1, 2}, 5.0, 0.0}); });
  add("angle, bent further", [](SystemBuilder& b) { b.add(AngleRow{{0, 1, 2}, 5.0, 0.0, 0.3}); });
  add("angle, bent less", [](SystemBuilder& b) { b.add(AngleRow{{0, 1, 2}, 5.0, 0.0, 2.5}); });
  add("user force", [](SystemBuilder& b) { b.set_user_force(quartic_bond(0, 2, 1.5)); });
  return out;
}

TEST(GeometricStiffness, FullPlusJacobianPartIsTheHessianOfTheEnergyForEveryRowType) {
  for (const Single& single : single_rows()) {
    const auto& [s, state] = single.scene;
    auto energy = [&](const VectorXd& q) {
      const State at{0.0, q, state.v};
      return row_energy(s, at) + external_energy(s, at);
    };
    const MatrixXd H =
        finite_jacobian([&](const VectorXd& q) { return finite_gradient(energy, q, 2e-3); }, state.q, 2e-3);
    Kkt kkt = with_geometric(s, state, GeometricStiffness::kFull, 1.0, spring_lambda(s, state.q));
    const MatrixXd Kg = geometric_by_columns(kkt), J = dense_rows(s, state.q).jacobian;
    ASSERT_GT(largest(Kg), 0.1) << single.name;
    EXPECT_LT(largest(J.transpose() * s.stiffness.asDiagonal() * J + Kg - H), 1e-7 * largest(H))
        << single.name;  // 1e-9
  }
}

TEST(GeometricStiffness, KeepsTheFractionOfTheNegativePartThatIsAskedFor) {
  for (const Single& single : single_rows()) {
    const auto& [s, state] = single.scene;
    const VectorXd lambda = spring_lambda(s, state.q);
    auto matrix = [&](GeometricStiffness kind, double kept) {
      Kkt kkt = with_geometric(s, state, GeometricStiffness::kOff, 1.0, lambda);
      kkt.set_geometric_stiffness(kind, 1.0, state, lambda, kept);
      return geometric_by_columns(kkt);
    };
    const MatrixXd full = matrix(GeometricStiffness::kFull, 0.0), positive = positive_part(full);
    EXPECT_LT(largest(matrix(GeometricStiffness::kClamped, 0.3) - positive - 0.3 * (full - positive)),
              1e-13 * largest(full))
        << single.name;  // 2e-15
  }
}

TEST(GeometricStiffness, FullPlusJacobianPartIsMinusTheDerivativeOfTheForces) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const TestScene scene = mixed_scene(seed, {.rods = false, .damping = false});
    const System& s = scene.system;
    auto forces = [&](const VectorXd& q) {
      VectorXd f;
      EXPECT_TRUE(evaluate_forces(s, State{scene.state.t, q, scene.state.v}, f).ok());
      return f;
    };
    const MatrixXd K = -finite_jacobian(forces, scene.state.q, 1e-3);
    Kkt kkt = with_geometric(s, scene.state, GeometricStiffness::kFull, 1.0, spring_lambda(s, scene.state.q));
    const MatrixXd J = dense_rows(s, scene.state.q).jacobian;
    ASSERT_GT(largest(K), 10.0);
    EXPECT_LT(largest(J.transpose() * s.stiffness.asDiagonal() * J + geometric_by_columns(kkt) - K),
              1e-8 * largest(K));  // 8e-11
  }
}

TEST(GeometricStiffness, FullIsMinusLambdaTimesHessianForAnyMultipliers) {
  Random random(1);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const TestScene scene = mixed_scene(seed, {.hard_angle = true});
    const System& s = scene.system;
    const VectorXd lambda = random.numbers(s.rows, 10.0);
    const double sigma = 0.04;
    Kkt kkt = with_geometric(s, scene.state, GeometricStiffness::kFull, sigma, lambda);
    VectorXd acting = lambda;
    for (int k = 0; k < s.rows; ++k)
      if (s.stiffness[k] == 0.0) acting[k] = 0.0;
    const MatrixXd expected = sigma * (dense_geometric(dense_rows(s, scene.state.q), acting) +
                                       dense_user_stiffness(s, scene.state));
    ASSERT_GT(largest(expected), 0.5);
    EXPECT_LT(largest(geometric_by_columns(kkt) - expected), 1e-12 * largest(expected));  // 3e-15
  }
}

TEST(GeometricStiffness, FullIsIndefiniteUnderCompression) {
  const Single single = single_rows()[1];
  const auto& [s, state] = single.scene;
  Kkt kkt = with_geometric(s, state, GeometricStiffness::kFull, 1.0, spring_lambda(s, state.q));
  EXPECT_LT(least_eigenvalue(geometric_by_columns(kkt)), -1.0);  // -32
}

TEST(GeometricStiffness, ClampedIsThePositivePartOfEachRowsBlock) {
  for (const Single& single : single_rows()) {
    const auto& [s, state] = single.scene;
    const VectorXd lambda = spring_lambda(s, state.q);
    const MatrixXd full =
        geometric_by_columns(with_geometric(s, state, GeometricStiffness::kFull, 0.5, lambda));
    const MatrixXd clamped =
        geometric_by_columns(with_geometric(s, state, GeometricStiffness::kClamped, 0.5, lambda));
    ASSERT_GT(largest(full), 0.05) << single.name;
    EXPECT_LT(largest(clamped - positive_part(full)), 1e-13 * largest(full)) << single.name;  // 3e-15
  }
}

TEST(GeometricStiffness, ClampedBendingKeepsSomeAndDropsSome) {
  for (int i : {3, 4, 5}) {
    const Single single = single_rows()[i];
    const auto& [s, state] = single.scene;
    const VectorXd lambda = spring_lambda(s, state.q);
    const MatrixXd full =
        geometric_by_columns(with_geometric(s, state, GeometricStiffness::kFull, 1.0, lambda));
    EXPECT_LT(least_eigenvalue(full), -0.1) << single.name;
    EXPECT_GT(-least_eigenvalue(-full), 0.1) << single.name;
  }
}

TEST(GeometricStiffness, ClampedIsPositiveSemidefiniteForAnyMultipliers) {
  Random random(2);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const TestScene scene = mixed_scene(seed, {.hard_angle = true});
    const VectorXd lambda = random.numbers(scene.system.rows, 100.0);
    const MatrixXd full = geometric_by_columns(
        with_geometric(scene.system, scene.state, GeometricStiffness::kFull, 1.0, lambda));
    const MatrixXd K = geometric_by_columns(
        with_geometric(scene.system, scene.state, GeometricStiffness::kClamped, 1.0, lambda));
    ASSERT_LT(least_eigenvalue(full), -1.0);
    ASSERT_GT(largest(K), 1.0);
    EXPECT_GT(least_eigenvalue(K), -1e-13 * largest(K));  // -2e-15
  }
}

TEST(GeometricStiffness, ClampedIsPositiveSemidefiniteForAnIndefiniteUserForce) {
  SystemBuilder builder;
  builder.add_particle(1.0, {0, 0, 0});
  builder.add_particle(1.0, {1, 0.5, 0.2});
  builder.set_user_force(quartic_bond(0, 1, -2.0));  // pushes apart
  const auto [s, state] = builder.build();
  const VectorXd none(s.rows);
  const MatrixXd full = geometric_by_columns(with_geometric(s, state, GeometricStiffness::kFull, 1.0, none));
  EXPECT_LT(least_eigenvalue(full), -1.0);
  const MatrixXd K = geometric_by_columns(with_geometric(s, state, GeometricStiffness::kClamped, 1.0, none));
  EXPECT_LT(largest(K - positive_part(full)), 1e-14 * largest(full));  // 2e-32
}

TEST(GeometricStiffness, OffAddsNothing) {
  const TestScene scene = mixed_scene(1);
  const VectorXd lambda = spring_lambda(scene.system, scene.state.q);
  Kkt kkt = with_geometric(scene.system, scene.state, GeometricStiffness::kFull, 1.0, lambda);
  ASSERT_GT(largest(geometric_by_columns(kkt)), 1.0);
  kkt.set_geometric_stiffness(GeometricStiffness::kOff, 1.0, scene.state, lambda);
  EXPECT_TRUE(geometric_by_columns(kkt).isZero(0.0));
}

TEST(GeometricStiffness, ZeroRestLengthHasTheHessianOfASquareAtEveryLength) {
  for (double length : {1.0, 1e-9, 0.0}) {
    SystemBuilder builder;
    builder.add_particle(1.0, {0, 0, 0});
    builder.add_particle(1.0, Vector3d(1, 2, -2) * (length / 3.0));
    builder.add_distance({0}, {1}, {7.0}, 0.0);
    const auto [s, state] = builder.build();
    MatrixXd expected(6, 6);
    expected << MatrixXd::Identity(3, 3), -MatrixXd::Identity(3, 3), -MatrixXd::Identity(3, 3),
        MatrixXd::Identity(3, 3);
    for (GeometricStiffness kind : {GeometricStiffness::kFull, GeometricStiffness::kClamped}) {
      Kkt kkt = with_geometric(s, state, kind, 1.0, spring_lambda(s, state.q));
      MatrixXd J(s.rows, 6);
      VectorXd column;
      for (int c = 0; c < 6; ++c) {
        kkt.multiply_jacobian(VectorXd::Unit(6, c), column);
        J.col(c) = column;
      }
      const MatrixXd H = J.transpose() * s.stiffness.asDiagonal() * J + geometric_by_columns(kkt);
      EXPECT_LT(largest(H - 7.0 * expected), 1e-14) << length;  // 9e-16
    }
  }
}

TEST(GeometricStiffness, IsProportionalToSigma) {
  const TestScene scene = mixed_scene(2);
  const VectorXd lambda = spring_lambda(scene.system, scene.state.q);
  for (GeometricStiffness kind : {GeometricStiffness::kFull, GeometricStiffness::kClamped}) {
    const MatrixXd one = geometric_by_columns(with_geometric(scene.system, scene.state, kind, 1.0, lambda));
    const MatrixXd tenth = geometric_by_columns(with_geometric(scene.system, scene.state, kind, 0.1, lambda));
    ASSERT_GT(largest(one), 1.0);
    EXPECT_LT(largest(tenth - 0.1 * one), 1e-14 * largest(one));  // 5e-17
  }
}

}  // namespace
}  // namespace feder
