#include "models/taut_string.h"

#include <gtest/gtest.h>

#include "tests/models/dense.h"

namespace feder {
namespace {

Model straight_string(TautString o) {
  o.modes = {};
  return make_taut_string(o);
}

TEST(TautString, IsStretchedToItsTension) {
  const TautString o;
  const Model model = straight_string(o);
  VectorXd phi;
  evaluate_phi(model.system, model.state.q, phi);
  int checked = 0;
  for (int k = 0; k < model.system.distance.size(); ++k) {
    if (!model.system.distance.active(k)) continue;
    EXPECT_NEAR(o.stiffness * phi[k], o.tension, 1e-10);
    ++checked;
  }
  EXPECT_EQ(checked, o.n + 1);
}

TEST(TautString, FrequenciesAreTheEigenvaluesOfTheGeometricStiffness) {
  const TautString o;
  const Model model = straight_string(o);
  const VectorXd omega =
      pencil_frequencies(dense_geometric(model.system, model.state), dense_mass(model.system));
  // n zeros along the string, then y and z in pairs
  EXPECT_LT(omega[o.n - 1], 1e-3);
  double worst = 0.0;
  for (int j = 1; j <= o.n; ++j)
    for (int axis = 0; axis < 2; ++axis)
      worst = std::max(worst, std::abs(omega[o.n + 2 * (j - 1) + axis] / taut_string_frequency(o, j) - 1.0));
  EXPECT_LT(worst, 1e-12);  // 1.4e-14
}

TEST(TautString, HighestFrequencySetsTheLimitOfTheStepWithoutGeometricStiffness) {
  // notes E8: dt < 2 / sqrt(lambda_max(Kg - Km, M))
  const TautString o;
  const Model model = straight_string(o);
  const Eigen::MatrixXd K =
      dense_geometric(model.system, model.state) - dense_stiffness(model.system, model.state.q);
  const VectorXd omega = pencil_frequencies(K, dense_mass(model.system));
  EXPECT_NEAR(omega.maxCoeff() / taut_string_frequency(o, o.n), 1.0, 1e-12);
}

TEST(TautString, IsDisplacedAcrossItself) {
  TautString o;
  o.modes = {{1, 1e-3}};
  const Model model = make_taut_string(o), straight = straight_string(o);
  const VectorXd shift = model.state.q - straight.state.q;
  EXPECT_NEAR(shift.cwiseAbs().maxCoeff(), 1e-3, 1e-5);
  for (int i = 0; i < model.system.nodes; ++i) {
    EXPECT_EQ(shift[3 * i], 0.0);
    EXPECT_EQ(shift[3 * i + 2], 0.0);
  }
}

}  // namespace
}  // namespace feder
