#include "models/linear_motion.h"

#include <gtest/gtest.h>

#include <cmath>

namespace feder {
namespace {

TEST(LinearMotion, StartsBitwiseAtItsStart) {
  for (double decay : {0.0, 0.3, 2.0, 7.0}) {
    const LinearMotion m = linear_motion(2.0, decay, {0.3, -1.7}, 0.0);
    EXPECT_EQ(m.x, 0.3);
    EXPECT_EQ(m.v, -1.7);
  }
}

TEST(LinearMotion, UndampedMotionIsHarmonic) {
  const LinearMotion m = linear_motion(3.0, 0.0, {0.5, 0.0}, 1.3);
  EXPECT_NEAR(m.x, 0.5 * std::cos(3.9), 1e-15);  // 1.7e-16
  EXPECT_NEAR(m.v, -1.5 * std::sin(3.9), 1e-15);
}

TEST(LinearMotion, CriticalMotionHasItsClosedForm) {
  const LinearMotion m = linear_motion(2.0, 2.0, {0.5, 1.0}, 0.8);
  EXPECT_NEAR(m.x, std::exp(-1.6) * (0.5 + 2.0 * 0.8), 1e-15);
}

TEST(LinearMotion, PassesTheCriticalDampingWithoutAJump) {
  const LinearMotion below = linear_motion(2.0, 2.0 - 1e-13, {0.5, 1.0}, 0.8);
  const LinearMotion above = linear_motion(2.0, 2.0 + 1e-13, {0.5, 1.0}, 0.8);
  EXPECT_NE(below.x, above.x);
  EXPECT_NEAR(below.x, above.x, 1e-13);
  EXPECT_NEAR(below.v, above.v, 1e-12);
}

TEST(LinearMotion, OverdampedMotionIsTheSumOfTwoDecays) {
  // roots -1 and -4: omega = 2, decay = 2.5
  const LinearMotion m = linear_motion(2.0, 2.5, {1.0, 0.0}, 0.9);
  EXPECT_NEAR(m.x, (4.0 * std::exp(-0.9) - std::exp(-3.6)) / 3.0, 1e-15);
}

TEST(LinearMotion, StaysFiniteForStrongDampingAndLongTimes) {
  const LinearMotion m = linear_motion(1.0, 1e6, {1.0, 0.0}, 1e6);
  EXPECT_NEAR(m.x, std::exp(-0.5), 1e-9);  // slow root -omega^2 / (2 decay)
}

}  // namespace
}  // namespace feder
