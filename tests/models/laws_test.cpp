// Expressions and curves as motions, targets, springs and forces of the engine.
#include "models/scene_file/laws.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/kkt.h"
#include "engine/system.h"
#include "tests/support/finite_difference.h"
#include "tests/support/random.h"

namespace feder {
namespace {

Expression in_time(const char* text) {
  return {text, {"t"}};
}
Expression tension(const char* text) {
  return {text, {"length", "rate"}};
}
ForceField field(const char* x, const char* y, const char* z, std::vector<int> nodes) {
  return {{Expression(x, kForceVariables), Expression(y, kForceVariables), Expression(z, kForceVariables)},
          std::move(nodes)};
}

TEST(Laws, AMotionHasTheDerivativesOfItsExpressions) {
  const Motion motion =
      motion_from(std::array{in_time("0.2*sin(3*t)"), in_time("t > 1 ? (t - 1)^3 : 0"), in_time("-0.5")});
  for (double t = 0.0; t < 3.0; t += 0.1) {
    const double late = t > 1.0 ? t - 1.0 : 0.0;
    EXPECT_LT((motion.position(t) - Vector3d(0.2 * std::sin(3 * t), late * late * late, -0.5)).norm(), 1e-15);
    EXPECT_LT((motion.velocity(t) - Vector3d(0.6 * std::cos(3 * t), 3 * late * late, 0.0)).norm(), 4e-15);
    EXPECT_LT((motion.acceleration(t) - Vector3d(-1.8 * std::sin(3 * t), 6 * late, 0.0)).norm(), 4e-15);
  }
}

TEST(Laws, AMotionMayMixExpressionsAndCurves) {
  const Curve ramp("ramp", {0.0, 1.0, 2.0}, {0.0, 1.0, 4.0});
  const Motion motion =
      motion_from(std::array{target_from(ramp), target_from(in_time("t^2")), target_from(in_time("0"))});
  EXPECT_EQ(motion.position(1.0), Vector3d(1.0, 1.0, 0.0));
  EXPECT_EQ(motion.velocity(0.3), Vector3d(ramp.at(0.3).first, 0.6, 0.0));
  EXPECT_EQ(motion.acceleration(0.3), Vector3d(ramp.at(0.3).second, 2.0, 0.0));
}

TEST(Laws, ASpringHasBothPartialDerivatives) {
  const SpringLaw law = law_from(tension("40*(length - 0.7) + 5*(length - 0.7)^3 + 0.3*rate*length"), 0.7);
  Random random(4);
  for (int i = 0; i < 100; ++i) {
    const double l = random.uniform(0.1, 2.0), r = random.uniform(-3.0, 3.0), x = l - 0.7;
    const Tension own = law.law(l, r);
    EXPECT_NEAR(own.force, 40 * x + 5 * x * x * x + 0.3 * r * l, 1e-13);
    EXPECT_NEAR(own.by_length, 40 + 15 * x * x + 0.3 * r, 1e-13);
    EXPECT_NEAR(own.by_rate, 0.3 * l, 1e-15);
  }
  EXPECT_FALSE(law.energy);
}

TEST(Laws, TheEnergyOfASpringIsTheIntegralOfItsTension) {
  const double rest = 0.7;
  const SpringLaw smooth = law_from(tension("40*(length - 0.7) + 5*(length - 0.7)^3"), rest),
                  rope = law_from(tension("length > 0.9 ? 30*(length - 0.9) : 0"), rest),
                  singular = law_from(tension("1/length^2"), rest),
                  stepped = law_from(tension("sign(length - 1)"), rest);
  for (double l = 0.05; l < 3.0; l += 0.0173) {
    const double x = l - rest, taut = std::max(l - 0.9, 0.0);
    EXPECT_NEAR(smooth.energy(l), 20 * x * x + 1.25 * x * x * x * x, 1e-13 * (1.0 + smooth.energy(l)));
    EXPECT_NEAR(rope.energy(l), 15 * taut * taut, 1e-13 * (1.0 + rope.energy(l)));
    EXPECT_NEAR(singular.energy(l), 1 / rest - 1 / l, 1e-12 * (1.0 + std::abs(singular.energy(l))));
    EXPECT_NEAR(stepped.energy(l), std::abs(l - 1) - 0.3, 1e-12);
  }
  EXPECT_EQ(smooth.energy(rest), 0.0);
  EXPECT_TRUE(std::isnan(singular.energy(-1.0)) || singular.energy(-1.0) < -1e6);
  EXPECT_TRUE(std::isnan(law_from(tension("sin(1e9*length)"), rest).energy(2.0)));
  EXPECT_TRUE(std::isnan(law_from(tension("ln(length)"), rest).energy(-0.5)));
}

TEST(Laws, ACurveIsASpringWithItsExactEnergy) {
  const Curve curve("spring", {0.5, 0.7, 1.0, 1.5}, {-10.0, 0.0, 4.0, 50.0});
  const SpringLaw law = law_from(curve, 0.7);
  for (double l = 0.3; l < 2.0; l += 0.0137) {
    const Tension own = law.law(l, 1.0);
    EXPECT_EQ(own.force, curve.at(l).value);
    EXPECT_EQ(own.by_length, curve.at(l).first);
    EXPECT_EQ(own.by_rate, 0.0);
    const double h = 1e-4, slope = (law.energy(l + h) - law.energy(l - h)) / (2 * h);
    EXPECT_NEAR(slope, own.force, 1e-6);
  }
  EXPECT_EQ(law.energy(0.7), 0.0);
}

TEST(Laws, AForceFieldActsOnItsNodesAlone) {
  const UserForce force = force_from({field("-3*x", "2*t", "-0.5*vz", {1}), field("0", "1", "0", {0, 1})});
  const VectorXd q = (VectorXd(9) << 1, 2, 3, 4, 5, 6, 7, 8, 9).finished(),
                 v = (VectorXd(9) << 1, 1, 1, 1, 1, 2, 1, 1, 1).finished();
  VectorXd out = VectorXd::Constant(9, 10.0);
  force.force(0.25, q, v, out);
  EXPECT_EQ(out, (VectorXd(9) << 10, 11, 10, -2, 11.5, 9, 10, 10, 10).finished());
  EXPECT_EQ(force.stencils, (std::vector<std::vector<int>>{{1}}));
  EXPECT_FALSE(force_from({field("t", "vx", "0", {0})}).stiffness);
}

TEST(Laws, StiffnessIsTheSymmetricDerivativeOfTheForce) {
  const UserForce force = force_from({field("-x*y + sin(z)*t", "-y^3 + vx*x", "exp(-x*z) - 4*z", {0, 2})});
  Random random(8);
  const VectorXd q = random.numbers(9), v = random.numbers(9);
  const Eigen::MatrixXd J = finite_jacobian(
      [&](const VectorXd& at) {
        VectorXd f = VectorXd::Zero(9);
        force.force(0.4, at, v, f);
        return f;
      },
      q, 1e-3);
  std::array<double, 18> K{};
  force.stiffness(0.4, q, v, K.data());
  for (int i = 0; i < 2; ++i) {
    const Eigen::Map<const Matrix3d> own(K.data() + 9 * i);
    const Matrix3d block = J.block<3, 3>(6 * i, 6 * i);
    EXPECT_LT((own + 0.5 * (block + block.transpose())).norm(), 1e-10);  // of the differences
    EXPECT_GT(own.norm(), 1.0);
    EXPECT_EQ(own, own.transpose());
  }
}

TEST(Laws, WrongNodesAndVariablesAreRefused) {
  EXPECT_THROW(force_from({field("0", "0", "0", {-1})}), InputError);
  EXPECT_THROW(force_from({field("0", "0", "0", {3, 1, 3})}), InputError);
  EXPECT_THROW(target_from(Expression("x", {"x"})), MisuseError);
  EXPECT_THROW(target_from(Expression()), MisuseError);
  EXPECT_THROW(law_from(in_time("t"), 1.0), MisuseError);
  EXPECT_THROW(law_from(tension("length"), std::nan("")), InputError);
}

}  // namespace
}  // namespace feder
