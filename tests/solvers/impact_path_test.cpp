// The impulse path against routes of their own: closed forms in the plane, a Runge-Kutta run while the slip
// turns, friction made smooth where it stops.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "solvers/contact/impact_law.h"
#include "tests/solvers/random_impact.h"
#include "tests/support/campaign.h"

namespace feder {
namespace {

using Eigen::Vector2d;
using test::BodyPair;

// ---- the plane: two straight phases, all in scalars ----

struct Plane {
  double nn, nt, tt;  // W
};

struct PlanarImpact {
  double normal, tangential;
  Slip slip;
};

// Rates of u_n and of the tangential impulse per p_n, before and after the slip stops at p_n = stop.
PlanarImpact planar_impact(const Plane& W, double u_n, double u_t, double mu, double e, bool stronge) {
  const double sign = u_t > 0.0 ? 1.0 : -1.0, braking = mu * W.tt - sign * W.nt;
  const double stop = braking > 0.0 ? std::abs(u_t) / braking : INFINITY;
  const bool sticks = std::abs(W.nt) <= mu * W.tt;
  const double first = -mu * sign, second = sticks ? -W.nt / W.tt : -mu * (W.nt > 0.0 ? 1.0 : -1.0);
  const double slope_1 = W.nn + W.nt * first, slope_2 = W.nn + W.nt * second;
  // Compression.
  const bool before = slope_1 > 0.0 && -u_n / slope_1 <= stop;
  const double at_stop = u_n + slope_1 * stop;
  const double p_c = before ? -u_n / slope_1 : stop - at_stop / slope_2;
  const double work = before ? 0.5 * u_n * p_c : 0.5 * (u_n + at_stop) * stop + 0.5 * at_stop * (p_c - stop);
  // Restitution: a triangle, or a triangle and a trapezium.
  double p_f = (1.0 + e) * p_c;
  if (stronge) {
    const double owed = -e * e * work;
    if (!before) {
      p_f = p_c + std::sqrt(2.0 * owed / slope_2);
    } else {
      p_f = p_c + std::sqrt(2.0 * owed / slope_1);
      if (p_f > stop) {
        const double left = owed - 0.5 * at_stop * (stop - p_c);
        p_f = stop + (std::sqrt(at_stop * at_stop + 2.0 * slope_2 * left) - at_stop) / slope_2;
      }
    }
  }
  const double tangential = first * std::min(p_f, stop) + (p_f > stop ? second * (p_f - stop) : 0.0);
  return {p_f, tangential, p_f <= stop ? Slip::kThroughout : sticks ? Slip::kStopped : Slip::kResumed};
}

TEST(ImpactPath, MatchesTheClosedFormInThePlane) {
  Random random(1);
  std::array<int, 4> slips{};
  int jams = 0;
  for (int i = 0; i < 20000; ++i) {
    SCOPED_TRACE(i);
    const double nn = random.uniform(0.5, 2.0), tt = random.uniform(0.2, 4.0);
    const Plane plane{nn, 0.99 * random.uniform() * std::sqrt(nn * tt), tt};
    const Vector3d u(-1.0, random.uniform(-3.0, 3.0), 0.0);
    const double mu = random.uniform(0.01, 2.5), e = test::random_restitution(random);
    const bool stronge = i % 2;
    const PlanarImpact expected = planar_impact(plane, u[0], u[1], mu, e, stronge);
    Matrix3d W;
    W << plane.nn, plane.nt, 0.0, plane.nt, plane.tt, 0.0, 0.0, 0.0, random.uniform(0.2, 4.0);
    const ImpactResult impact =
        resolve_impact(W, u, mu, e, stronge ? ImpactRule::kStronge : ImpactRule::kPoisson);
    const Vector3d p(expected.normal, expected.tangential, 0.0);
    EXPECT_LT((impact.impulse - p).norm(), 1e-12 * p.norm());  // 4e-14
    EXPECT_EQ(impact.slip, expected.slip);
    EXPECT_EQ(impact.steps, 0);
    ++slips[static_cast<int>(impact.slip)];
    jams += impact.jammed;
  }
  for (const Slip slip : {Slip::kThroughout, Slip::kStopped, Slip::kResumed})
    EXPECT_GT(slips[static_cast<int>(slip)], 500);  // 9000, 9000, 2000
  EXPECT_GT(jams, 500);
}

// The same through the series: a slip a little out of the plane, to which a large W_22 brings it back.
TEST(ImpactPath, SeriesMatchesTheClosedFormNextToThePlane) {
  Random random(2);
  int turning = 0;
  for (int i = 0; i < 500; ++i) {
    SCOPED_TRACE(i);
    const Plane plane{1.0, random.uniform(-0.9, 0.9), 1.0};
    const Vector3d u(-1.0, random.uniform(-1.0, 1.0), 1e-13);
    const double mu = random.uniform(0.1, 1.5);
    Matrix3d W;
    W << plane.nn, plane.nt, 0.0, plane.nt, plane.tt, 0.0, 0.0, 0.0, 10.0;
    const PlanarImpact expected = planar_impact(plane, u[0], u[1], mu, 0.5, true);
    const ImpactResult impact = resolve_impact(W, u, mu, 0.5);
    const Vector3d p(expected.normal, expected.tangential, 0.0);
    EXPECT_LT((impact.impulse - p).norm(), 1e-10 * p.norm());
    turning += impact.steps > 0;
  }
  EXPECT_GT(turning, 400);
}

// ---- a path of its own: u as a function of p_n, friction -mu s / sqrt(s^2 + smoothing^2) ----

struct Path {
  Vector3d u;
  double compression = 0.0, restitution = 0.0, least_speed = INFINITY;
};

Path follow(const Matrix3d& W, const Vector3d& u, double mu, double p_n, int steps, double smoothing) {
  const auto rate = [&](const Vector3d& v) -> Vector3d {
    const double speed = std::sqrt(v[1] * v[1] + v[2] * v[2] + smoothing * smoothing);
    return W.col(0) - W.col(1) * (mu * v[1] / speed) - W.col(2) * (mu * v[2] / speed);
  };
  Path out{u};
  const double h = p_n / steps;
  for (int i = 0; i < steps; ++i) {
    const Vector3d k1 = rate(out.u), k2 = rate(out.u + 0.5 * h * k1), k3 = rate(out.u + 0.5 * h * k2),
                   k4 = rate(out.u + h * k3), next = out.u + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4);
    // Simpson's rule, with the middle by Hermite interpolation.
    const double middle = 0.5 * (out.u[0] + next[0]) + h / 8.0 * (k1 - rate(next))[0];
    const double work = h / 6.0 * (out.u[0] + 4.0 * middle + next[0]);
    (work < 0.0 ? out.compression : out.restitution) += work;
    out.u = next;
    out.least_speed = std::min(out.least_speed, out.u.tail<2>().norm());
  }
  return out;
}

TEST(ImpactPathCampaign, TurningSlipMatchesRungeKutta) {
  Random random(3);
  int compared = 0;
  double worst = 0.0;
  for (int i = 0; i < test::campaign_cases(20000); ++i) {
    const BodyPair pair = test::random_pair(random);
    const double mu = random.uniform(0.05, 1.5), e = random.uniform(0.0, 1.0);
    const ImpactResult impact = resolve_impact(pair.W, pair.u, mu, e);
    if (impact.slip != Slip::kThroughout) continue;
    const Path path = follow(pair.W, pair.u, mu, impact.impulse[0], 2000, 0.0);
    if (path.least_speed < 0.05 * pair.u.norm()) continue;
    ++compared;
    const double difference = (path.u - impact.velocity).norm() / pair.u.norm();
    worst = std::max(worst, difference);
    EXPECT_LT(difference, 1e-9) << "case " << i;
    // The step with the end of compression is counted as a whole.
    EXPECT_NEAR(path.restitution, -e * e * path.compression, -1e-5 * path.compression) << "case " << i;
  }
  EXPECT_GT(compared, test::campaign_cases(20000) / 10);
  std::printf("%d cases, largest difference of velocity %.1e\n", compared, worst);
}

// Richardson from a smoothing and half of it, less of it where the slip is close to the edge of the cone.
TEST(ImpactPathCampaign, StopsAndNewSlipsMatchSmoothFriction) {
  Random random(4);
  std::array<int, 4> slips{};
  double worst = 0.0, worst_work = 0.0;
  for (int i = 0; slips[2] + slips[3] < test::campaign_cases(2000); ++i) {
    // Strong coupling, so that friction often fails to hold.
    const Matrix3d turn = test::random_rotation(random);
    const Vector3d size(random.uniform(0.05, 1.0), random.uniform(0.05, 1.0), random.uniform(2.0, 5.0));
    Matrix3d W = turn * size.asDiagonal() * turn.transpose();
    W = 0.5 * (W + W.transpose()).eval();
    const Vector3d u(-1.0, random.uniform(), random.uniform());
    const double mu = random.uniform(0.05, 2.0), e = random.uniform(0.0, 1.0);
    const ImpactResult impact = resolve_impact(W, u, mu, e);
    const bool rare = impact.slip == Slip::kResumed;
    if (impact.slip == Slip::kThroughout || (!rare && i % 8 != 0)) continue;
    ++slips[static_cast<int>(impact.slip)];
    const double p = impact.impulse[0];
    double difference = 1.0, work = 1.0;
    for (double smoothing = 1e-3; std::max(difference, work) > 2e-4 && smoothing > 1e-5; smoothing *= 0.25) {
      const int steps = 200 + static_cast<int>(p * mu * W.trace() / smoothing);
      const Path coarse = follow(W, u, mu, p, steps, smoothing),
                 fine = follow(W, u, mu, p, 2 * steps, 0.5 * smoothing);
      difference = (2.0 * fine.u - coarse.u - impact.velocity).norm();
      const double lost = 2.0 * fine.compression - coarse.compression;
      work = std::abs(2.0 * fine.restitution - coarse.restitution + e * e * lost) / -lost;
    }
    worst = std::max(worst, difference);
    worst_work = std::max(worst_work, work);
    EXPECT_LT(difference, 2e-4) << "case " << i;
    EXPECT_LT(work, 2e-4) << "case " << i;
  }
  EXPECT_GT(slips[static_cast<int>(Slip::kResumed)], 0);
  std::printf("stuck %d, set off again %d, largest difference of velocity %.1e, of work %.1e\n", slips[2],
              slips[3], worst, worst_work);
}

}  // namespace
}  // namespace feder
