// Rotations against closed forms, composition and quadrature (notes B5 to B8, C2).
#include "engine/rotation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

namespace feder {
namespace {

constexpr double kIdentity[4] = {1.0, 0.0, 0.0, 0.0};

struct Pose {
  double q[4] = {kIdentity[0], kIdentity[1], kIdentity[2], kIdentity[3]};
  Matrix3d matrix() const { return rotation_matrix(q); }
  double defect() const {
    return std::abs(std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]) - 1.0);
  }
};

Matrix3d rotated(const Vector3d& theta) {
  return Eigen::AngleAxisd(theta.norm(), theta.normalized()).toRotationMatrix();
}

TEST(Skew, IsTheCrossProductAndThePrintedMatrixIsNot) {
  const Vector3d w(1.0, -2.0, 3.0), r(0.5, 4.0, -1.0);
  EXPECT_LT((skew(w) * r - w.cross(r)).norm(), 1e-15);
  Matrix3d printed;  // notes B5
  printed << 0.0, -w[1], w[2], w[1], 0.0, -w[0], -w[2], w[0], 0.0;
  EXPECT_GT((printed * r - w.cross(r)).norm(), 1.0);
  EXPECT_LT((printed * r - Vector3d(w[0], w[2], w[1]).cross(r)).norm(), 1e-15);
}

TEST(ExponentialUpdate, IsTheExactRotation) {
  for (double size : {1e-12, 1e-6, 1e-4, 0.3, 3.0, 50.0}) {
    const Vector3d theta = size * Vector3d(2.0, -1.0, 2.0) / 3.0;
    Pose pose;
    turn(theta, RotationUpdate::kExponential, pose.q);
    EXPECT_LT((pose.matrix() - rotated(theta)).norm(), 1e-14 * std::max(1.0, size)) << size;  // 6e-16
  }
}

TEST(ExponentialUpdate, StaysOfUnitLengthOver100000Steps) {
  Pose pose;
  for (int n = 0; n < 100000; ++n)
    turn(Vector3d(0.01, 0.02 * std::sin(n), -0.015), RotationUpdate::kExponential, pose.q);
  EXPECT_LT(pose.defect(), 1e-14);  // 2e-16
}

TEST(NormalisedEulerUpdate, LagsByTheThirdPowerOverTwelve) {
  for (double angle : {0.02, 0.1}) {
    Pose pose;
    turn(Vector3d(0.0, 0.0, angle), RotationUpdate::kNormalisedEuler, pose.q);
    const double turned = 2.0 * std::atan2(pose.q[3], pose.q[0]);
    EXPECT_NEAR(turned, 2.0 * std::atan(0.5 * angle), 1e-15);
    EXPECT_NEAR((angle - turned) / (angle * angle * angle / 12.0), 1.0, 0.01);  // 0.9999, 0.9985
  }
}

TEST(RotationMatrixUpdate,
     DriftsFromOrthogonalityAsPredicted) {  // notes B6: R += dt [w]x R, the failure demo
  const Vector3d w(0.0, 0.0, 2.0);
  Matrix3d R = Matrix3d::Identity();
  const double dt = 0.01;
  for (int n = 0; n < 100; ++n) R += dt * skew(w) * R;
  const double growth = std::pow(1.0 + dt * dt * w.squaredNorm(), 50.0);
  EXPECT_GT(growth, 1.01);
  EXPECT_NEAR(R.col(0).norm(), growth, 1e-12);
}

TEST(RightJacobian, IsTheDerivativeOfTheExponential) {
  for (double size : {1e-9, 5e-4, 2e-3, 0.7, 3.0}) {
    const Vector3d theta = size * Vector3d(1.0, 2.0, -2.0) / 3.0, d(0.3, -0.2, 0.5);
    constexpr double kStep = 1e-6;
    const Matrix3d change = rotated(theta).transpose() * rotated(theta + kStep * d),
                   back = rotated(theta).transpose() * rotated(theta - kStep * d);
    const Matrix3d slope = (change - back) / (2.0 * kStep);
    EXPECT_LT((slope - skew(right_jacobian(theta) * d)).norm(), 1e-8) << size;
    EXPECT_LT((right_jacobian(theta) * theta - theta).norm(), 1e-15 * std::max(1.0, size)) << size;
  }
}

TEST(QuaternionRate, IsTheDerivativeOfTheUpdate) {
  Pose pose;
  turn({0.4, -1.0, 0.3}, RotationUpdate::kExponential, pose.q);
  const Vector3d w(1.0, 2.0, -0.5);
  double rate[4];
  quaternion_rate(pose.q, w, rate);
  Pose later = pose, before = pose;
  constexpr double kStep = 1e-5;
  turn(kStep * w, RotationUpdate::kExponential, later.q);
  turn(-kStep * w, RotationUpdate::kExponential, before.q);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(rate[i], (later.q[i] - before.q[i]) / (2.0 * kStep), 1e-9);
}

const Vector3d kMoments(1.0, 2.0, 2.5);

// World angular momentum of a free body and its energy.
Vector3d momentum(const Pose& pose, const Vector3d& w) {
  return pose.matrix() * kMoments.cwiseProduct(w);
}
double energy(const Vector3d& w) {
  return 0.5 * kMoments.dot(w.cwiseProduct(w));
}

TEST(FreeRotation, KeepsTheWorldMomentumAndBoundsTheEnergy) {
  Pose pose;
  Vector3d w(0.3, 4.0, 0.1);  // about the middle axis: it flips
  const Vector3d L = momentum(pose, w);
  const double E = energy(w);
  double worst = 0.0, least = w[1];
  for (int n = 0; n < 20000; ++n) {
    rotate_freely(kMoments, 0.01, w, pose.q);
    worst = std::max(worst, std::abs(energy(w) / E - 1.0));
    least = std::min(least, w[1]);
  }
  EXPECT_LT(least, -3.9);  // it did flip
  EXPECT_LT((momentum(pose, w) - L).norm() / L.norm(), 1e-12);
  EXPECT_LT(worst, 1e-3);
  EXPECT_GT(worst, 1e-8);
}

TEST(FreeRotation, IsReversible) {
  Pose pose;
  Vector3d w(1.0, 4.0, -2.0);
  for (int n = 0; n < 1000; ++n) rotate_freely(kMoments, 0.01, w, pose.q);
  ASSERT_GT((w - Vector3d(1.0, 4.0, -2.0)).norm(), 0.1);
  for (int n = 0; n < 1000; ++n) rotate_freely(kMoments, -0.01, w, pose.q);
  EXPECT_LT((w - Vector3d(1.0, 4.0, -2.0)).norm(), 1e-11);
  EXPECT_LT((pose.matrix() - Matrix3d::Identity()).norm(), 1e-11);
}

TEST(FreeRotation, IsOfSecondOrder) {
  auto end = [](int steps) {
    Pose pose;
    Vector3d w(1.0, 4.0, -2.0);
    for (int n = 0; n < steps; ++n) rotate_freely(kMoments, 1.0 / steps, w, pose.q);
    return pose.matrix();
  };
  const Matrix3d exact = end(12800);
  const double order = std::log2((end(100) - exact).norm() / (end(200) - exact).norm());
  EXPECT_NEAR(order, 2.0, 0.05);
}

TEST(ImplicitGyroscopicStep, SolvesItsEquationAndNeverGainsEnergy) {
  for (double dt : {1e-4, 1.0 / 60.0, 0.5, 10.0})
    for (const Vector3d& w : {Vector3d(1.0, 4.0, -2.0), Vector3d(0.01, 10.0, 0.0), Vector3d(9.0, 0.1, 4.0)}) {
      const Vector3d next = implicit_gyroscopic_step(kMoments, dt, w);
      ASSERT_TRUE(next.allFinite()) << dt;
      const Vector3d residual =
          kMoments.cwiseProduct(next - w) + dt * next.cross(kMoments.cwiseProduct(next));
      EXPECT_LT(residual.norm(), 1e-12 * kMoments.cwiseProduct(w).norm()) << dt;
      EXPECT_LT(energy(next), energy(w)) << dt;
    }
}

TEST(ImplicitGyroscopicStep, LeavesRotationAboutAPrincipalAxisAlone) {
  EXPECT_EQ(implicit_gyroscopic_step(kMoments, 0.1, {0.0, 3.0, 0.0}), Vector3d(0.0, 3.0, 0.0));
}

}  // namespace
}  // namespace feder
