// The independent check integrates theta'' = -w^2 sin theta by Taylor series in long double.
#include "models/pendulum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "models/spring_pendulum.h"

namespace feder {
namespace {

using Real = long double;
constexpr int kOrder = 24;

struct Swing {
  Real theta, rate;
};

// one Taylor step; s = sin theta and c = cos theta obey s' = c theta', c' = -s theta'
Swing step(const Swing& start, Real w2, Real dt) {
  std::array<Real, kOrder + 2> theta{}, s{}, c{};
  theta[0] = start.theta, theta[1] = start.rate;
  s[0] = std::sin(start.theta), c[0] = std::cos(start.theta);
  for (int m = 0; m < kOrder; ++m) {
    if (m > 0) {
      Real cs = 0, ss = 0;
      for (int i = 0; i < m; ++i) cs += c[i] * (m - i) * theta[m - i], ss += s[i] * (m - i) * theta[m - i];
      s[m] = cs / m, c[m] = -ss / m;
    }
    theta[m + 2 <= kOrder + 1 ? m + 2 : kOrder + 1] = -w2 * s[m] / ((m + 1) * (m + 2));
  }
  Swing end{theta[kOrder], kOrder * theta[kOrder]};
  for (int m = kOrder - 1; m >= 0; --m) end.theta = end.theta * dt + theta[m];
  for (int m = kOrder - 1; m >= 1; --m) end.rate = end.rate * dt + m * theta[m];
  return end;
}

double angle_of(const State& s) {
  return std::atan2(s.q[3], -s.q[4]);
}

TEST(Pendulum, ExactMotionAgreesWithTaylorIntegration) {
  for (double angle : {0.3, 1.5, 3.0}) {
    Pendulum o;
    o.angle = angle, o.length = 0.7;
    const Model model = make_pendulum(o);
    const Real w2 = static_cast<Real>(o.gravity) / o.length;
    const int steps = 400;
    const Real dt = static_cast<float>(model.end_time / steps);  // i dt is exact in double
    Swing y{angle, 0};
    double worst = 0.0, largest = 0.0;
    for (int i = 1; i <= steps; ++i) {
      y = step(y, w2, dt);
      const State s = model.exact(static_cast<double>(i * dt));
      const double theta = static_cast<double>(y.theta), speed = o.length * static_cast<double>(y.rate);
      largest = std::max(largest, std::abs(speed));
      worst =
          std::max({worst, std::abs(s.q[3] - o.length * std::sin(theta)),
                    std::abs(s.q[4] + o.length * std::cos(theta)), std::abs(s.v[3] - speed * std::cos(theta)),
                    std::abs(s.v[4] - speed * std::sin(theta))});
    }
    ASSERT_GT(largest, 0.5);
    EXPECT_LT(worst, 1e-12) << angle;  // 1.1e-13 at 3.0
  }
}

TEST(Pendulum, ExactAngleObeysItsEquation) {
  const Pendulum o;
  const Model model = make_pendulum(o);
  for (double t : {0.3, 1.1, 2.9}) {
    const double e = 1e-3;
    auto theta = [&](double at) { return angle_of(model.exact(at)); };
    const double second =
        (16.0 * (theta(t + e) + theta(t - e)) - theta(t + 2 * e) - theta(t - 2 * e) - 30.0 * theta(t)) /
        (12.0 * e * e);
    const double expected = -o.gravity / o.length * std::sin(theta(t));
    ASSERT_GT(std::abs(expected), 0.5);
    EXPECT_NEAR(second, expected, 1e-8);  // 1.7e-9
  }
}

TEST(Pendulum, ReturnsAfterOnePeriod) {
  for (double angle : {0.1, 3.0, 3.141}) {
    Pendulum o;
    o.angle = angle;
    const Model model = make_pendulum(o);
    const double t = 0.23 * pendulum_period(o);
    const State now = model.exact(t), half = model.exact(t + 0.5 * pendulum_period(o)),
                full = model.exact(t + pendulum_period(o));
    EXPECT_GT((half.v - now.v).norm(), 0.1);
    EXPECT_NEAR(half.q[3], -now.q[3], 1e-12);
    EXPECT_LT((full.q - now.q).norm() + (full.v - now.v).norm(), 5e-11);  // 6.0e-12 at 3.141, 3.5e-14 at 3.0
  }
}

TEST(Pendulum, ExactMotionStaysOnTheRod) {
  const Model model = make_pendulum();
  double gap = 0.0, rate = 0.0;
  for (int i = 0; i <= 100; ++i) {
    const State s = model.exact(i * model.end_time / 100.0);
    gap = std::max(gap, std::abs(s.q.tail<3>().norm() - model.scene_length));
    rate = std::max(rate, std::abs(s.q.tail<3>().dot(s.v.tail<3>())));
  }
  EXPECT_GT((model.exact(0.3 * model.end_time).q - model.state.q).norm(), 0.1);
  EXPECT_LT(gap, 1e-15);   // 1.1e-16
  EXPECT_LT(rate, 1e-14);  // 4.4e-16
}

TEST(Pendulum, SmallSwingsHaveTheTextbookPeriod) {
  Pendulum o;
  o.angle = 1e-4;
  EXPECT_NEAR(pendulum_period(o), 2.0 * 3.141592653589793 * std::sqrt(o.length / o.gravity), 1e-8);
}

TEST(Pendulum, OnASpringHasNoExactSolution) {
  Pendulum o;
  o.stiffness = 1e4;
  EXPECT_FALSE(make_pendulum(o).exact);
  EXPECT_TRUE(make_pendulum().exact);
}

TEST(SpringPendulum, StartsStretchedAndMovingAcross) {
  SpringPendulum o;
  o.elongation = 0.2, o.speed = 3.0;
  const State s = make_spring_pendulum(o).state;
  EXPECT_NEAR(s.q.tail<3>().norm(), 1.2, 1e-15);
  EXPECT_NEAR(s.v.tail<3>().norm(), 3.0, 1e-15);
  EXPECT_NEAR(s.q.tail<3>().dot(s.v.tail<3>()), 0.0, 1e-15);
}

}  // namespace
}  // namespace feder
