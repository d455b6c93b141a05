// Bending rows (notes E2) against finite differences, automatic differentiation of other formulas, and
// geometry.
#include "engine/bending.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/check.h"
#include "engine/kkt.h"
#include "tests/support/finite_difference.h"
#include "tests/support/random.h"
#include "tests/support/row_formulas.h"

namespace feder {
namespace {

using std::numbers::pi;
using Vector9d = Eigen::Matrix<double, 9, 1>;
using Matrix9d = Eigen::Matrix<double, 9, 9>;

/// Three nodes with bending angle psi in a random plane, edges of random length.
VectorXd bent(double psi, Random& random) {
  const Vector3d t = random.vector().normalized(), normal = t.cross(random.vector()).normalized();
  const Vector3d x0 = random.vector(), a = random.uniform(0.3, 2.0) * t;
  const Vector3d b = random.uniform(0.3, 2.0) * (std::cos(psi) * t + std::sin(psi) * normal.cross(t));
  VectorXd q(9);
  q << x0, x0 + a, x0 + a + b;
  return q;
}

template <class Row>
Row some_row() {
  Row row;
  row.nodes = {0, 1, 2};
  row.stiffness = 1.0;
  if constexpr (std::is_same_v<Row, AngleRow>) row.rest_angle = 0.8;
  return row;
}

template <class Row>
VectorXd phi_of(const Row& row, const VectorXd& q) {
  VectorXd phi(Row::kRows);
  EXPECT_TRUE(row.evaluate(q.data(), phi.data(), nullptr));
  return phi;
}

template <class Row>
Eigen::MatrixXd jacobian_of(const Row& row, const VectorXd& q) {
  VectorXd phi(Row::kRows);
  Eigen::Matrix<double, Row::kRows, 9, Eigen::RowMajor> J;
  EXPECT_TRUE(row.evaluate(q.data(), phi.data(), J.data()));
  return J;
}

template <class Row>
Matrix9d hessian_of(const Row& row, const VectorXd& q, const VectorXd& lambda) {
  Matrix9d H;
  row.hessian(q.data(), lambda.data(), H);
  return H;
}

/// Value, gradient and Hessian of component i by automatic differentiation of row_formulas.h.
template <class Row>
Derivatives<9> reference(const Row& row, int i, const VectorXd& q) {
  return differentiate<9>(
      [&](const auto* x) {
        if constexpr (std::is_same_v<Row, CurvatureRow>)
          return curvature_formula(x)[i];
        else
          return angle_formula(x, row.rest_angle);
      },
      q.data());
}

double largest(const Eigen::MatrixXd& m) {
  return m.cwiseAbs().maxCoeff();
}

template <class Row>
class BendingRow : public testing::Test {};
using RowTypes = testing::Types<CurvatureRow, AngleRow>;
TYPED_TEST_SUITE(BendingRow, RowTypes);

TYPED_TEST(BendingRow, JacobianAgreesWithAutomaticDifferentiation) {
  const TypeParam row = some_row<TypeParam>();
  Random random(1);
  double worst = 0.0;
  for (int trial = 0; trial < 2000; ++trial) {
    const double psi = trial % 4 == 0 ? pi / 2 : trial % 4 == 1 ? 3.0 : random.uniform(0.05, 3.0);
    const VectorXd q = bent(psi, random);
    const Eigen::MatrixXd J = jacobian_of(row, q);
    const VectorXd phi = phi_of(row, q);
    ASSERT_GT(largest(J), 0.1);
    for (int i = 0; i < TypeParam::kRows; ++i) {
      const Derivatives<9> d = reference(row, i, q);
      worst = std::max(worst, std::abs(phi[i] - d.value) / (1.0 + phi.norm()));
      worst = std::max(worst, largest(J.row(i).transpose() - d.gradient) / largest(J));
    }
  }
  EXPECT_LT(worst, 1e-12);  // 1e-13
}

TYPED_TEST(BendingRow, HessianAgreesWithAutomaticDifferentiation) {
  const TypeParam row = some_row<TypeParam>();
  Random random(2);
  double worst = 0.0;
  for (int trial = 0; trial < 1000; ++trial) {
    const double psi = trial % 4 == 0 ? pi / 2 : trial % 4 == 1 ? 3.0 : random.uniform(0.05, 3.0);
    const VectorXd q = bent(psi, random), lambda = random.numbers(TypeParam::kRows);
    Matrix9d expected = Matrix9d::Zero();
    for (int i = 0; i < TypeParam::kRows; ++i) expected += lambda[i] * reference(row, i, q).hessian;
    ASSERT_GT(largest(expected), 1e-3);
    worst = std::max(worst, largest(hessian_of(row, q, lambda) - expected) / largest(expected));
  }
  EXPECT_LT(worst, 1e-11);  // 1e-13
}

TYPED_TEST(BendingRow, JacobianAgreesWithFiniteDifferences) {
  const TypeParam row = some_row<TypeParam>();
  Random random(3);
  for (double psi : {0.3, pi / 2, 2.0, 3.0}) {
    const VectorXd q = bent(psi, random);
    const Eigen::MatrixXd J = jacobian_of(row, q);
    const Eigen::MatrixXd F = finite_jacobian([&](const VectorXd& x) { return phi_of(row, x); }, q, 1e-4);
    ASSERT_GT(largest(J), 0.1);
    EXPECT_LT(largest(J - F), 1e-7 * largest(J)) << psi;  // 2e-11
  }
}

TYPED_TEST(BendingRow, HessianAgreesWithFiniteDifferencesOfTheJacobian) {
  const TypeParam row = some_row<TypeParam>();
  Random random(4);
  for (double psi : {0.3, pi / 2, 2.0, 3.0}) {
    const VectorXd q = bent(psi, random), lambda = random.numbers(TypeParam::kRows);
    const Matrix9d H = hessian_of(row, q, lambda);
    const Eigen::MatrixXd F = finite_jacobian(
        [&](const VectorXd& x) -> VectorXd { return jacobian_of(row, x).transpose() * lambda; }, q, 1e-4);
    ASSERT_GT(largest(H), 0.1);
    EXPECT_LT(largest(H - F), 1e-6 * largest(H)) << psi;  // 5e-11
  }
}

TYPED_TEST(BendingRow, HessianIsSymmetric) {
  const TypeParam row = some_row<TypeParam>();
  Random random(5);
  for (int trial = 0; trial < 200; ++trial) {
    const VectorXd q = bent(random.uniform(0.1, 3.0), random), lambda = random.numbers(TypeParam::kRows);
    const Matrix9d H = hessian_of(row, q, lambda);
    ASSERT_GT(largest(H), 1e-3);
    EXPECT_LT(largest(H - H.transpose()), 1e-12 * largest(H));  // 6e-16
  }
}

TYPED_TEST(BendingRow, DoesNotSeeTranslations) {
  const TypeParam row = some_row<TypeParam>();
  Random random(6);
  for (int trial = 0; trial < 200; ++trial) {
    const VectorXd q = bent(random.uniform(0.1, 3.0), random), lambda = random.numbers(TypeParam::kRows);
    const VectorXd v = random.vector().replicate<3, 1>();
    const Eigen::MatrixXd J = jacobian_of(row, q);
    const Matrix9d H = hessian_of(row, q, lambda);
    EXPECT_LT((J * v).norm(), 1e-13 * J.norm());  // 2e-16
    EXPECT_LT((H * v).norm(), 1e-12 * H.norm());  // 1e-16
  }
}

TYPED_TEST(BendingRow, EnergyAndItsForcesDoNotSeeRotations) {
  const TypeParam row = some_row<TypeParam>();
  Random random(7);
  for (int trial = 0; trial < 200; ++trial) {
    const VectorXd q = bent(random.uniform(0.1, 3.0), random);
    const Eigen::Quaterniond R(Eigen::AngleAxisd(random.uniform(-3.0, 3.0), random.vector().normalized()));
    VectorXd turned(9), v(9);
    const Vector3d omega = random.vector(), shift = random.vector();
    for (int i = 0; i < 3; ++i) {
      const Vector3d x = q.segment<3>(3 * i);
      turned.segment<3>(3 * i) = R * x + shift;
      v.segment<3>(3 * i) = omega.cross(x);
    }
    const VectorXd phi = phi_of(row, q);
    ASSERT_GT(phi.norm(), 1e-4);
    EXPECT_NEAR(phi_of(row, turned).norm(), phi.norm(), 1e-11 * (1.0 + phi.norm()));  // 2e-13
    const Eigen::MatrixXd J = jacobian_of(row, q);
    EXPECT_LT(std::abs(phi.dot(J * v)), 1e-12 * phi.norm() * J.norm());  // 4e-16: no torque, no power
  }
}

TYPED_TEST(BendingRow, ReportsEdgesOfLengthZero) {
  const TypeParam row = some_row<TypeParam>();
  Random random(8);
  for (int edge = 0; edge < 3; ++edge) {  // the first, the second, both
    VectorXd q = bent(1.0, random);
    if (edge != 1) q.segment<3>(0) = q.segment<3>(3);
    if (edge != 0) q.segment<3>(6) = q.segment<3>(3);
    VectorXd phi = VectorXd::Constant(TypeParam::kRows, NAN),
             J = VectorXd::Constant(9 * TypeParam::kRows, NAN);
    EXPECT_FALSE(row.evaluate(q.data(), phi.data(), J.data()));
    EXPECT_FALSE(row.evaluate(q.data(), phi.data(), nullptr));
    EXPECT_TRUE(phi.allFinite());
    EXPECT_TRUE(J.isZero(0.0));
    EXPECT_TRUE(hessian_of(row, q, VectorXd::Ones(TypeParam::kRows)).isZero(0.0));
  }
}

TYPED_TEST(BendingRow, ReportsAFoldedAngle) {
  const TypeParam row = some_row<TypeParam>();
  VectorXd q(9), phi = VectorXd::Constant(TypeParam::kRows, NAN),
                 J = VectorXd::Constant(9 * TypeParam::kRows, NAN);
  q << 0, 0, 0, 1, 0, 0, 0.25, 0, 0;
  EXPECT_FALSE(row.evaluate(q.data(), phi.data(), J.data()));
  EXPECT_TRUE(phi.allFinite());
  EXPECT_TRUE(J.isZero(0.0));
}

TYPED_TEST(BendingRow, ScalesAsAPureAngleDoes) {
  const TypeParam row = some_row<TypeParam>();
  Random random(9);
  const VectorXd q = bent(1.2, random), larger = 1000.0 * q;
  EXPECT_LT(largest(phi_of(row, larger) - phi_of(row, q)), 1e-13);                     // 2e-16
  EXPECT_LT(largest(1000.0 * jacobian_of(row, larger) - jacobian_of(row, q)), 1e-12);  // 3e-16
}

TEST(CurvatureRow, HasTheLengthTwoTanHalfTheAngle) {
  Random random(11);
  for (double psi : {1e-8, 1e-3, 0.1, 1.0, pi / 2, 2.5, 3.0}) {
    const VectorXd kappa = phi_of(some_row<CurvatureRow>(), bent(psi, random));
    const double expected = 2.0 * std::tan(0.5 * psi);
    EXPECT_NEAR(kappa.norm(), expected, 1e-14 / std::cos(0.5 * psi) / std::cos(0.5 * psi))
        << psi;  // 2e-16 times that
  }
}

TEST(CurvatureRow, PointsAlongTheBinormal) {
  VectorXd q(9);
  q << 0, 0, 0, 1, 0, 0, 1, 1, 0;  // turns left by 90 degrees about +z
  const VectorXd kappa = phi_of(some_row<CurvatureRow>(), q);
  EXPECT_NEAR(kappa[2], 2.0, 1e-15);  // 0
  EXPECT_EQ(kappa[0], 0.0);
  EXPECT_EQ(kappa[1], 0.0);
}

VectorXd singular_values(const VectorXd& q) {
  return Eigen::JacobiSVD<Eigen::MatrixXd>(jacobian_of(some_row<CurvatureRow>(), q)).singularValues();
}

TEST(CurvatureRow, HasRankTwoAtTheStraightState) {
  Random random(12);
  for (int trial = 0; trial < 50; ++trial) {
    const VectorXd sigma = singular_values(bent(0.0, random));
    EXPECT_GT(sigma[1], 0.5);
    EXPECT_LT(sigma[2], 1e-14 * sigma[0]);  // 3e-16
  }
}

TEST(CurvatureRow, HasRankThreeWhereItIsBent) {
  Random random(13);
  for (double psi : {0.1, 1.0, 3.0}) EXPECT_GT(singular_values(bent(psi, random))[2], 0.02) << psi;
}

TEST(CurvatureRow, JacobianAtTheStraightStateGivesTheWholeBendingStiffness) {
  VectorXd q(9), sideways = VectorXd::Zero(9);
  q << 0, 0, 0, 1, 0, 0, 2, 0, 0;
  sideways[4] = 1.0;  // the middle node along y: kappa = -4 y, so kappa^T kappa = 16 y^2
  const Eigen::MatrixXd J = jacobian_of(some_row<CurvatureRow>(), q);
  EXPECT_TRUE(phi_of(some_row<CurvatureRow>(), q).isZero(0.0));
  EXPECT_NEAR((J * sideways).squaredNorm(), 4.0, 1e-14);  // 0
  auto energy = [&](const VectorXd& x) { return 0.5 * phi_of(some_row<CurvatureRow>(), x).squaredNorm(); };
  auto gradient = [&](const VectorXd& x) { return finite_gradient(energy, x, 1e-3); };
  const Eigen::MatrixXd H = finite_jacobian(gradient, q, 1e-3);
  EXPECT_LT(largest(J.transpose() * J - H), 1e-8);  // 7e-12
}

TEST(CurvatureRow, TurnsWithTheRodUnderRigidRotation) {
  // kappa is a vector: J (omega x x) = omega x kappa, which is 0 only at the straight state
  Random random(14);
  for (double psi : {0.0, 0.4, 1.5, 2.8}) {
    const VectorXd q = bent(psi, random);
    const Vector3d omega = random.vector(), kappa = phi_of(some_row<CurvatureRow>(), q);
    VectorXd v(9);
    for (int i = 0; i < 3; ++i) v.segment<3>(3 * i) = omega.cross(Vector3d(q.segment<3>(3 * i)));
    const VectorXd rate = jacobian_of(some_row<CurvatureRow>(), q) * v;
    if (psi > 0.0) {
      EXPECT_GT(rate.norm(), 0.01);
    }
    EXPECT_LT((rate - omega.cross(kappa)).norm(), 1e-13 * (1.0 + kappa.norm()));  // 3e-16
  }
}

TEST(AngleRow, DoesNotSeeRigidRotation) {
  Random random(15);
  for (int trial = 0; trial < 200; ++trial) {
    const VectorXd q = bent(random.uniform(0.05, 3.1), random);
    const Vector3d omega = random.vector();
    VectorXd v(9);
    for (int i = 0; i < 3; ++i) v.segment<3>(3 * i) = omega.cross(Vector3d(q.segment<3>(3 * i)));
    const Eigen::MatrixXd J = jacobian_of(some_row<AngleRow>(), q);
    ASSERT_GT(v.norm(), 1e-3);
    EXPECT_LT((J * v).norm(), 1e-13 * J.norm() * v.norm());  // 1e-16
  }
}

TEST(AngleRow, IsTheAngleBetweenTheEdgesMinusTheRestAngle) {
  Random random(16);
  for (double psi : {1e-6, 0.1, 1.0, pi / 2, 2.5, 3.0, pi - 1e-6})
    EXPECT_NEAR(phi_of(some_row<AngleRow>(), bent(psi, random))[0], psi - 0.8, 1e-14) << psi;  // 1e-16
}

TEST(AngleRow, IsDegenerateAtZeroAndAtPi) {
  VectorXd straight(9), folded(9);
  straight << 0, 0, 0, 1, 0, 0, 3, 0, 0;
  folded << 0, 0, 0, 1, 0, 0, -1, 0, 0;
  const AngleRow row = some_row<AngleRow>();
  double phi = NAN;
  VectorXd J = VectorXd::Constant(9, NAN), lambda = VectorXd::Ones(1);
  EXPECT_FALSE(row.evaluate(straight.data(), &phi, J.data()));
  EXPECT_EQ(phi, -0.8);  // the angle is known there, its derivative is not
  EXPECT_TRUE(J.isZero(0.0));
  EXPECT_TRUE(hessian_of(row, straight, lambda).isZero(0.0));
  EXPECT_FALSE(row.evaluate(folded.data(), &phi, J.data()));
  EXPECT_NEAR(phi, pi - 0.8, 1e-15);  // 0
  EXPECT_TRUE(J.isZero(0.0));
  EXPECT_TRUE(hessian_of(row, folded, lambda).isZero(0.0));
}

TEST(AngleRow, StaysSharpCloseToTheDegenerateStates) {
  Random random(17);
  for (double psi : {1e-5, pi - 1e-5}) {
    const VectorXd q = bent(psi, random);
    const Eigen::MatrixXd J = jacobian_of(some_row<AngleRow>(), q);
    // the gradient has the length it has at every angle: |grad_a| = 1/|a|
    const double edge = (q.segment<3>(3) - q.segment<3>(0)).norm();
    EXPECT_NEAR(J.leftCols<3>().norm() * edge, 1.0, 1e-9) << psi;  // 0
  }
}

TEST(CurvatureRow, StraightIsNotDegenerate) {
  VectorXd q(9), phi = VectorXd::Constant(3, NAN), J = VectorXd::Constant(27, NAN);
  q << 0, 0, 0, 1, 0, 0, 3, 0, 0;
  EXPECT_TRUE(some_row<CurvatureRow>().evaluate(q.data(), phi.data(), J.data()));
  EXPECT_TRUE(phi.isZero(0.0));
  EXPECT_GT(largest(J), 0.1);
}

}  // namespace
}  // namespace feder
