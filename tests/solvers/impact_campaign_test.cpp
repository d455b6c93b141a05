// Sweeps of impacts (notes D5(a), D6): which rules gain energy, and what every impact keeps.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "solvers/contact/impact_law.h"
#include "tests/solvers/random_impact.h"
#include "tests/support/campaign.h"

namespace feder {
namespace {

using test::BodyPair;

constexpr int kImpacts = 20000;

/// States looked at, those that gained energy, and the largest gain as a part of the contact energy.
struct Gains {
  int states = 0, gaining = 0;
  double largest = -1.0;

  void add(double change, double energy) {
    ++states;
    gaining += change > 1e-12 * energy;
    largest = std::max(largest, change / energy);
  }
};

Gains sweep_rod(ImpactRule rule) {
  Gains out;
  const int angles = std::max(8, test::campaign_cases(44));
  for (int i = 1; i <= angles; ++i) {
    const ContactBody rod = test::rod_on_end(0.5 * std::numbers::pi * i / (angles + 1));
    const Matrix3d W = contact_inverse_mass({}, rod, test::ground_axes());
    const Eigen::Matrix2d mass = W.topLeftCorner<2, 2>().inverse();
    for (int slip = -10; slip <= 10; ++slip)
      for (int spin = -10; spin <= 10; ++spin) {
        const BodyVelocity velocity{{0.3 * slip, 0.0, -1.0}, {0.0, 0.6 * spin, 0.0}};
        const Vector3d u = contact_velocity({}, {}, rod, velocity, test::ground_axes());
        if (u[0] >= 0.0) continue;
        const double energy = 0.5 * u.head<2>().dot(mass * u.head<2>());
        for (const double friction : {0.1, 0.2, 0.3, 0.5, 0.8, 1.0, 1.3, 1.6})
          for (const double restitution : {0.0, 0.25, 0.5, 0.75, 1.0}) {
            const ImpactResult impact = resolve_impact(W, u, friction, restitution, rule);
            EXPECT_EQ(impact.status, StatusCode::kOk);
            EXPECT_LE(impact.impulse.tail<2>().norm(), friction * impact.impulse[0] * (1.0 + 1e-12));
            out.add(impact.energy_change, energy);
          }
      }
  }
  return out;
}

void print(const char* name, const Gains& g) {
  std::printf("%s: %d of %d states gain energy (%.2f %%), largest change %+.2e of the contact energy\n", name,
              g.gaining, g.states, 100.0 * g.gaining / g.states, g.largest);
}

TEST(ImpactCampaign, NaiveRuleGainsEnergyOnARod) {
  const Gains gains = sweep_rod(ImpactRule::kNaive);
  print("naive", gains);
  EXPECT_GT(gains.gaining, 100);  // 4.1 %
  EXPECT_GT(gains.largest, 0.5);  // 0.98
}

TEST(ImpactCampaign, StrongesRuleNeverGainsEnergyOnARod) {
  const Gains gains = sweep_rod(ImpactRule::kStronge);
  print("Stronge", gains);
  EXPECT_EQ(gains.gaining, 0);
}

TEST(ImpactCampaign, PoissonsRuleGainsNoEnergyOnARodEither) {
  const Gains gains = sweep_rod(ImpactRule::kPoisson);
  print("Poisson", gains);
  EXPECT_EQ(gains.gaining, 0);
}

/// What holds for every impact along the path, relative to the velocities and the contact energy.
void expect_sound(const ImpactResult& impact, const Vector3d& u, double energy, double friction,
                  double rounding) {
  ASSERT_EQ(impact.status, StatusCode::kOk);
  ASSERT_TRUE(impact.impulse.allFinite() && impact.velocity.allFinite());
  EXPECT_GE(impact.velocity[0], -rounding * u.norm());
  EXPECT_GE(impact.impulse[0], 0.0);
  if (std::isfinite(friction))
    EXPECT_LE(impact.impulse.tail<2>().norm(), friction * impact.impulse[0] * (1.0 + rounding));
  EXPECT_LE(impact.energy_change, rounding * energy);
  EXPECT_LE(impact.friction_work, rounding * energy);
  EXPECT_NEAR(impact.energy_change, impact.compression_work + impact.restitution_work + impact.friction_work,
              rounding * energy);
}

struct Tally {
  int slips[4] = {}, jammed = 0, largest_steps = 0;
  long steps = 0;

  void add(const ImpactResult& impact) {
    ++slips[static_cast<int>(impact.slip)];
    jammed += impact.jammed;
    largest_steps = std::max(largest_steps, impact.steps);
    steps += impact.steps;
  }
  void print(const char* name, const Gains& gains) const {
    feder::print(name, gains);
    std::printf("  slid %d, stuck %d, set off again %d, jammed %d; steps %.1f, at most %d\n", slips[1],
                slips[2], slips[3], jammed, static_cast<double>(steps) / gains.states, largest_steps);
  }
};

// Energy and momentum of the bodies themselves, not of the contact's matrix.
TEST(ImpactCampaign, BoxesNeverGainEnergyAndKeepTheirMomentum) {
  Random random(1);
  Gains gains;
  Tally tally;
  double momentum = 0.0;
  for (int i = 0; i < test::campaign_cases(kImpacts); ++i) {
    SCOPED_TRACE(testing::Message() << "case " << i << " of seed 1");
    const BodyPair pair = test::random_pair(random);
    const double friction = test::random_friction(random), restitution = test::random_restitution(random);
    const ImpactResult impact = resolve_impact(pair.W, pair.u, friction, restitution);
    expect_sound(impact, pair.u, 0.5 * pair.u.dot(pair.W.inverse() * pair.u), friction, 1e-12);
    EXPECT_EQ(resolve_impact(pair.W, pair.u, friction, restitution).impulse, impact.impulse);
    tally.add(impact);

    const Vector3d p = pair.axes * impact.impulse;
    const BodyVelocity a = after_impulse(pair.a, pair.velocity_a, -p),
                       b = after_impulse(pair.b, pair.velocity_b, p);
    const double before =
        test::kinetic_energy(pair.a, pair.velocity_a) + test::kinetic_energy(pair.b, pair.velocity_b);
    gains.add(test::kinetic_energy(pair.a, a) + test::kinetic_energy(pair.b, b) - before, before);
    if (pair.a.inverse_mass == 0.0) continue;
    const Vector3d change = (a.linear - pair.velocity_a.linear) / pair.a.inverse_mass +
                            (b.linear - pair.velocity_b.linear) / pair.b.inverse_mass;
    momentum = std::max(momentum, change.norm() / (p.norm() + b.linear.norm() / pair.b.inverse_mass));
  }
  tally.print("boxes, Stronge", gains);
  std::printf("  momentum changes by %.1e\n", momentum);
  EXPECT_EQ(gains.gaining, 0);
  EXPECT_LT(momentum, 1e-12);  // 5e-16
}

/// Any symmetric positive definite matrix, condition up to 1e3: stronger coupling than boxes have.
Matrix3d random_inverse_mass(Random& random) {
  const Matrix3d turn = test::random_rotation(random);
  const Vector3d size = random.vector(1.5).unaryExpr([](double x) { return std::pow(10.0, x); });
  const Matrix3d W = turn * size.asDiagonal() * turn.transpose();
  return 0.5 * (W + W.transpose());
}

Gains impacts_of_any_matrix(ImpactRule rule, Tally& tally) {
  Random random(2);
  Gains gains;
  for (int i = 0; i < test::campaign_cases(kImpacts); ++i) {
    SCOPED_TRACE(testing::Message() << "case " << i << " of seed 2");
    const Matrix3d W = random_inverse_mass(random);
    Vector3d u(random.uniform(-1.0, 0.0), random.uniform(), random.uniform());
    if (random.below(2)) u.tail<2>() *= std::pow(10.0, random.uniform(-4.0, 1.0));
    const double friction = test::random_friction(random);
    const ImpactResult impact = resolve_impact(W, u, friction, test::random_restitution(random), rule);
    const double energy = 0.5 * u.dot(W.inverse() * u);
    expect_sound(impact, u, energy, friction, 1e-11);
    gains.add(impact.energy_change, energy);
    tally.add(impact);
  }
  return gains;
}

TEST(ImpactCampaign, NoMatrixGainsEnergyByStrongesRule) {
  Tally tally;
  const Gains gains = impacts_of_any_matrix(ImpactRule::kStronge, tally);
  tally.print("any matrix, Stronge", gains);
  EXPECT_EQ(gains.gaining, 0);
  EXPECT_GT(tally.jammed, 0);
}

TEST(ImpactCampaign, NoMatrixSeenGainsEnergyByPoissonsRule) {
  Tally tally;
  const Gains gains = impacts_of_any_matrix(ImpactRule::kPoisson, tally);
  tally.print("any matrix, Poisson", gains);
  EXPECT_EQ(gains.gaining, 0);
}

// Condition up to 1e12 or closed directions, velocities and friction over many decades.
TEST(ImpactCampaign, ExtremeStatesEndFiniteOrByName) {
  Random random(3);
  int singular = 0, limit = 0;
  for (int i = 0; i < test::campaign_cases(200000); ++i) {
    SCOPED_TRACE(testing::Message() << "case " << i << " of seed 3");
    const double spread = random.uniform(0.0, 3.0);
    Vector3d size = random.vector(spread).unaryExpr([](double x) { return std::pow(10.0, x); });
    const bool closed = random.below(4) == 0, masked = random.below(4) == 0;
    if (closed) size[2] = 0.0;
    const Matrix3d turn = random.below(4) ? test::random_rotation(random) : Matrix3d::Identity();
    Matrix3d W = turn * size.asDiagonal() * turn.transpose();
    W = 0.5 * (W + W.transpose()).eval();
    if (masked) W.row(2).setZero(), W.col(2).setZero();
    Vector3d u(-std::pow(10.0, random.uniform(-12.0, 3.0)), random.uniform(), random.uniform());
    u.tail<2>() *= std::pow(10.0, random.uniform(-18.0, 6.0));
    u[1 + random.below(2)] *= random.below(4) ? 1.0 : 0.0;
    const double friction =
        random.below(2) ? std::pow(10.0, random.uniform(-12.0, 12.0)) : test::random_friction(random);
    const double restitution = test::random_restitution(random);
    const ImpactRule rule = random.below(2) ? ImpactRule::kStronge : ImpactRule::kPoisson;
    const ImpactResult impact = resolve_impact(W, u, friction, restitution, rule);
    ASSERT_TRUE(impact.impulse.allFinite() && impact.velocity.allFinite());
    singular += impact.status == StatusCode::kSingular;
    limit += impact.status == StatusCode::kLimitReached;
    if (impact.status != StatusCode::kOk) {
      EXPECT_TRUE(closed || masked);
      continue;
    }
    const double size_u = u.norm() + W.norm() * impact.impulse.norm();
    EXPECT_GE(impact.velocity[0], -1e-11 * size_u);
    EXPECT_LE(impact.energy_change, 1e-11 * impact.impulse.norm() * size_u);
    if (std::isfinite(friction))
      EXPECT_LE(impact.impulse.tail<2>().norm(), friction * impact.impulse[0] * (1.0 + 1e-12));
  }
  std::printf("extreme states: %d singular, %d out of steps\n", singular, limit);
  EXPECT_LE(limit, 2);
}

}  // namespace
}  // namespace feder
