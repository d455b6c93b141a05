#include "models/bending_rod.h"

#include <gtest/gtest.h>

#include "engine/energy.h"
#include "tests/models/dense.h"

namespace feder {
namespace {

Model straight_rod(int n, RodSupport support) {
  BendingRod o;
  o.n = n, o.support = support, o.amplitude = 0.0;
  return make_bending_rod(o);
}

// largest relative error of the first three bending frequencies; each comes twice, along y and z
double frequency_error(int n, RodSupport support) {
  BendingRod o;
  o.n = n, o.support = support;
  const Model model = straight_rod(n, support);
  const VectorXd omega =
      pencil_frequencies(dense_stiffness(model.system, model.state.q), dense_mass(model.system));
  double worst = 0.0;
  for (int j = 0; j < 3; ++j)
    for (int axis = 0; axis < 2; ++axis)
      worst = std::max(worst, std::abs(omega[2 * j + axis] / beam_frequencies(o)[j] - 1.0));
  return worst;
}

TEST(BendingRod, CantileverFrequenciesAgreeWithBeamTheory) {
  EXPECT_LT(frequency_error(200, RodSupport::kCantilever), 0.01);  // 1.3e-4
}

TEST(BendingRod, PinnedFrequenciesAgreeWithBeamTheory) {
  EXPECT_LT(frequency_error(200, RodSupport::kPinnedEnds), 0.01);  // 1.9e-4
}

TEST(BendingRod, FrequenciesConvergeWithSecondOrder) {
  for (RodSupport support : {RodSupport::kCantilever, RodSupport::kPinnedEnds}) {
    const double coarse = frequency_error(21, support), fine = frequency_error(41, support);
    ASSERT_GT(fine, 1e-6);
    const double order = std::log2(coarse / fine);
    EXPECT_NEAR(order, 2.0, 0.15);  // 2.03, 1.99
  }
}

TEST(BendingRod, StepMatrixEqualsTheEnergyHessianAtTheStraightState) {
  const Model model = straight_rod(6, RodSupport::kCantilever);
  const Eigen::MatrixXd K = dense_stiffness(model.system, model.state.q);
  const std::vector<int> at = free_coordinates(model.system);
  const double eps = 1e-6;
  auto energy = [&](int i, double di, int j, double dj) {
    State s = model.state;
    s.q[at[i]] += di;
    s.q[at[j]] += dj;
    return row_energy(model.system, s);
  };
  // along the rod EA / l decides, across it EI / l^3: two scales, judged each by itself
  double worst[2] = {0.0, 0.0}, largest[2] = {0.0, 0.0};
  for (int i = 0; i < K.rows(); ++i)
    for (int j = 0; j < K.cols(); ++j) {
      const int across = at[i] % 3 > 0 && at[j] % 3 > 0;
      const double h = (energy(i, eps, j, eps) - energy(i, eps, j, -eps) - energy(i, -eps, j, eps) +
                        energy(i, -eps, j, -eps)) /
                       (4.0 * eps * eps);
      worst[across] = std::max(worst[across], std::abs(K(i, j) - h));
      largest[across] = std::max(largest[across], std::abs(h));
    }
  for (int across : {0, 1}) {
    ASSERT_GT(largest[across], 1.0);
    EXPECT_LT(worst[across], 1e-4 * largest[across]);  // along 5.8e-11, across 3.3e-8
  }
}

TEST(BendingRod, StartsInextensiblyInItsFirstMode) {
  for (const char* support : {"cantilever", "pinned"}) {
    BendingRod o;
    o.support = support == std::string("pinned") ? RodSupport::kPinnedEnds : RodSupport::kCantilever;
    const Model model = make_bending_rod(o);
    VectorXd phi;
    evaluate_phi(model.system, model.state.q, phi);
    double stretch = 0.0, highest = 0.0;
    for (int k = 0; k < model.system.distance.size(); ++k) stretch = std::max(stretch, std::abs(phi[k]));
    for (int i = 0; i < o.n; ++i) highest = std::max(highest, model.state.q[3 * i + 1]);
    EXPECT_NEAR(highest, o.amplitude, 0.02 * o.amplitude) << support;
    EXPECT_LT(stretch, o.support == RodSupport::kPinnedEnds ? 1e-6 : 1e-16) << support;
  }
}

TEST(BendingRod, FirstModeOscillatesAtItsFrequency) {
  // M a = -omega^2 M (x - straight) across the rod, up to the error of the discrete mode
  BendingRod o;
  o.n = 101;
  const Model bent = make_bending_rod(o), straight = straight_rod(o.n, o.support);
  const VectorXd shift = bent.state.q - straight.state.q;
  const Eigen::MatrixXd K = dense_stiffness(straight.system, straight.state.q);
  const std::vector<int> at = free_coordinates(straight.system);
  VectorXd y = VectorXd::Zero(K.rows());
  for (int i = 0; i < y.size(); ++i)
    if (at[i] % 3 == 1) y[i] = shift[at[i]];
  ASSERT_GT(y.norm(), 1e-3);
  const double rayleigh = std::sqrt(y.dot(K * y) / y.dot(dense_mass(straight.system).cwiseProduct(y)));
  EXPECT_NEAR(rayleigh / beam_frequencies(o)[0], 1.0, 1e-3);  // -1.6e-5
}

// Notes E2: three nodes on the x axis, links of 1 m, stiffness 1 N m; the middle one moves along y.
class StraightAngle : public testing::Test {
 protected:
  static VectorXd nodes(double y) {
    VectorXd q = VectorXd::Zero(9);
    q[3] = 1.0, q[4] = y, q[6] = 2.0;
    return q;
  }
  static double psi(double y) {
    AngleRow row;
    row.nodes = {0, 1, 2};
    double phi = 0.0;
    (void)row.evaluate(nodes(y).data(), &phi, nullptr);
    return phi;
  }
};

TEST_F(StraightAngle, IsReportedDegenerateByTheScalarRow) {
  AngleRow row;
  row.nodes = {0, 1, 2};
  double phi = 1.0, jacobian[9];
  EXPECT_FALSE(row.evaluate(nodes(0.0).data(), &phi, jacobian));
  EXPECT_EQ(phi, 0.0);
  EXPECT_TRUE(row.evaluate(nodes(0.1).data(), &phi, jacobian));
}

TEST_F(StraightAngle, StopsASystemByName) {
  SystemBuilder builder;
  for (double x : {0.0, 1.0, 2.0}) builder.add_particle(1.0, {x, 0.0, 0.0});
  builder.add(AngleRow{{0, 1, 2}, 1.0, 0.0, 0.5});
  const auto [system, state] = builder.build();
  Kkt kkt;
  kkt.prepare(system);
  const Status status = kkt.evaluate(state.q);
  EXPECT_EQ(status.code, StatusCode::kSingular);
  EXPECT_NE(status.reason.find("angle row 0 (nodes 0, 1, 2)"), std::string::npos) << status.reason;
}

TEST_F(StraightAngle, MakesTheUnsignedAngleMissTheBendingStiffness) {
  // energy 1/2 psi^2 has the second derivative 4, its J^T D J by central difference 0
  const double eps = 1e-4, energy = 0.5 * psi(eps) * psi(eps);
  const double hessian = 2.0 * energy / (eps * eps);
  EXPECT_NEAR(hessian, 4.0, 1e-6);
  const double J = (psi(eps) - psi(-eps)) / (2.0 * eps);
  EXPECT_EQ(J * J, 0.0);
}

TEST_F(StraightAngle, KeepsTheBendingStiffnessInTheCurvatureRow) {
  CurvatureRow row;
  row.nodes = {0, 1, 2};
  double kappa[3], jacobian[27];
  ASSERT_TRUE(row.evaluate(nodes(0.0).data(), kappa, jacobian));
  const Eigen::Map<const Eigen::Matrix<double, 3, 9, Eigen::RowMajor>> J(jacobian);
  EXPECT_DOUBLE_EQ(J.col(4).squaredNorm(), 4.0);
}

}  // namespace
}  // namespace feder
