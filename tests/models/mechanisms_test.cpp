// Joints closed at the start, velocities that fit them, and how many of the rows depend on others.
#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <cmath>

#include "engine/check.h"
#include "engine/energy.h"
#include "engine/kkt.h"
#include "models/catalog.h"
#include "models/heavy_top.h"

namespace feder {
namespace {

// Every mechanism, and settings that reach its other branches.
const std::vector<std::string>& specs() {
  static const std::vector<std::string> list = {
      "heavy_top",
      "heavy_top:start=steady,tilt=1.9",
      "heavy_top:precession=-3,stiffness=1e5",
      "double_pendulum",
      "double_pendulum:upper_rate=3,lower_rate=-2,lower_length=0.3,stiffness=1e5,angular_stiffness=1e3",
      "n_pendulum",
      "n_pendulum:n=40,angle=2",
      "four_bar",
      "four_bar:branch=crossed,angle=4,speed=-3,tilt=2",
      "four_bar:crank=0.4,coupler=1,rocker=0.4,angle=2.5",
      "slider_crank",
      "slider_crank:drive=motor,angle=4",
      "flexible_linkage",
      "flexible_linkage:segments=3,angle=5,speed=-4",
  };
  return list;
}

class Mechanism : public testing::TestWithParam<std::string> {
 protected:
  const Model model = make_model(GetParam());
};

std::string test_name(const testing::TestParamInfo<std::string>& info) {
  std::string name = std::to_string(info.index) + "_" + info.param.substr(0, info.param.find(':'));
  return name;
}

TEST_P(Mechanism, IsClosedAtTheStart) {
  VectorXd phi;
  evaluate_phi(model.system, model.state.q, phi);
  EXPECT_LT(phi.cwiseAbs().maxCoeff(), 1e-13);
}

TEST_P(Mechanism, StartsWithVelocitiesThatFitItsJoints) {
  Kkt kkt;
  kkt.prepare(model.system);
  kkt.set_step(1.0, 1.0);
  ASSERT_TRUE(kkt.evaluate(model.state.q).ok());
  VectorXd rate;
  kkt.multiply_jacobian(model.state.v, rate);
  // a spring may change its length
  for (int k = 0; k < model.system.rows; ++k)
    if (model.system.row_name(k).starts_with("anchor distance")) rate[k] = 0.0;
  EXPECT_LT(rate.cwiseAbs().maxCoeff(), 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Scenes, Mechanism, testing::ValuesIn(specs()), test_name);

/// Hard rows and their rank at the start.
std::pair<int, int> rows_and_rank(const std::string& spec) {
  const Model model = make_model(spec);
  const System& s = model.system;
  Kkt kkt;
  kkt.prepare(s);
  kkt.set_step(0.0, 0.0);  // only hard rows act
  EXPECT_TRUE(kkt.evaluate(model.state.q).ok());
  Eigen::MatrixXd J(s.rows, 3 * s.nodes);
  VectorXd column;
  int hard = 0;
  for (int k = 0; k < s.rows; ++k) hard += std::isinf(s.stiffness[k]);
  for (int i = 0; i < 3 * s.nodes; ++i) {
    kkt.multiply_jacobian(VectorXd::Unit(3 * s.nodes, i), column);
    J.col(i) = s.inverse_mass[i] > 0.0 ? column : VectorXd::Zero(s.rows);
  }
  Eigen::JacobiSVD<Eigen::MatrixXd> svd(J);
  svd.setThreshold(1e-9);
  return {hard, static_cast<int>(svd.rank())};
}

using Counts = std::pair<int, int>;

TEST(Mechanisms, HaveTheRedundantRowsOfTheirKind) {
  EXPECT_EQ(rows_and_rank("heavy_top"), Counts(3, 3));
  EXPECT_EQ(rows_and_rank("double_pendulum"), Counts(10, 10));
  EXPECT_EQ(rows_and_rank("n_pendulum:n=10"), Counts(50, 50));
  EXPECT_EQ(rows_and_rank("four_bar"), Counts(20, 17));
  EXPECT_EQ(rows_and_rank("slider_crank"), Counts(20, 17));
  EXPECT_EQ(rows_and_rank("slider_crank:drive=motor"), Counts(21, 18));
  EXPECT_EQ(rows_and_rank("flexible_linkage"), Counts(20, 20));
}

TEST(Mechanisms, ParallelogramLosesARowWhereItIsFlat) {
  EXPECT_EQ(rows_and_rank("four_bar:crank=0.4,coupler=1,rocker=0.4,angle=2.5"), Counts(20, 17));
  EXPECT_EQ(rows_and_rank("four_bar:crank=0.4,coupler=1,rocker=0.4,angle=0,speed=0"), Counts(20, 16));
}

TEST(Mechanisms, TiltedLinkagesHaveNoCoordinateAxis) {
  const Model model = make_model("four_bar");
  for (const Body& body : model.system.bodies)
    EXPECT_GT(orientation(body, model.state.q).cwiseAbs().minCoeff(), 1e-3);
}

std::string message_of(const std::string& spec) {
  try {
    (void)make_model(spec);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Mechanisms, RefuseWhatCannotBeAssembled) {
  EXPECT_NE(message_of("four_bar:rocker=0.1,angle=2").find("where coupler and rocker meet"),
            std::string::npos);
  EXPECT_NE(message_of("four_bar:crank=1,coupler=1,rocker=1,angle=0").find("more than 0"), std::string::npos);
  EXPECT_NE(message_of("four_bar:crank=0.4,coupler=1,rocker=0.4,angle=0").find("not in line"),
            std::string::npos);
  EXPECT_NE(message_of("slider_crank:crank=0.6").find("less than the rod = 0.5"), std::string::npos);
  EXPECT_NE(message_of("heavy_top:start=steady,spin=10").find("at least"), std::string::npos);
}

TEST(HeavyTop, HasTheMomentumOfItsSpin) {
  HeavyTop o;
  o.precession = 2.0;
  const Model model = make_heavy_top(o);
  const double axial = 0.5 * o.mass * o.radius * o.radius,
               across = o.mass * (3.0 * o.radius * o.radius + o.height * o.height) / 12.0 +
                        o.mass * o.distance * o.distance;
  const double s = std::sin(o.tilt), c = std::cos(o.tilt);
  ASSERT_EQ(model.conserved.size(), 3u);
  EXPECT_NEAR(model.conserved[1].value(model.system, model.state),
              axial * o.spin * c + across * o.precession * s * s, 1e-14);
  EXPECT_NEAR(model.conserved[2].value(model.system, model.state), axial * o.spin, 1e-14);
}

}  // namespace
}  // namespace feder
