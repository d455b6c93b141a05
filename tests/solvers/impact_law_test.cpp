// The rules of one contact (notes D2, D3, D5, D6): what they have in common, where they part, Painleve.
#include "solvers/contact/impact_law.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/check.h"
#include "tests/solvers/random_impact.h"

namespace feder {
namespace {

using Eigen::Vector2d;
using test::BodyPair;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kCases = 200;
constexpr ImpactRule kFrictional[] = {ImpactRule::kNaive, ImpactRule::kPoisson, ImpactRule::kStronge};

Matrix3d rod_inverse_mass(double angle) {
  return contact_inverse_mass({}, test::rod_on_end(angle), test::ground_axes());
}

void expect_same(const ImpactResult& a, const ImpactResult& b) {
  EXPECT_EQ(a.impulse, b.impulse);
  EXPECT_EQ(a.velocity, b.velocity);
  EXPECT_EQ(a.energy_change, b.energy_change);
}

TEST(ImpactLaw, SeparatingAndRestingContactsAreUntouchedBitwise) {
  Random random(1);
  for (int i = 0; i < kCases; ++i) {
    const BodyPair pair = test::random_pair(random);
    Vector3d u = pair.u;
    u[0] = i % 2 ? 0.0 : -u[0];
    for (const ImpactRule rule : kFrictional) {
      const ImpactResult impact = resolve_impact(pair.W, u, 0.7, 1.0, rule);
      EXPECT_EQ(impact.velocity, u);
      EXPECT_EQ(impact.impulse, Vector3d::Zero());
      EXPECT_EQ(impact.slip, Slip::kNone);
    }
  }
}

TEST(ImpactLaw, WithoutFrictionAllRulesAreNewtonsBitwise) {
  Random random(2);
  for (int i = 0; i < kCases; ++i) {
    const BodyPair pair = test::random_pair(random);
    const double e = test::random_restitution(random);
    const ImpactResult newton = resolve_impact(pair.W, pair.u, 0.0, e, ImpactRule::kNewton);
    EXPECT_EQ(newton.impulse, Vector3d(-(1.0 + e) * pair.u[0] / pair.W(0, 0), 0.0, 0.0));
    for (const ImpactRule rule : kFrictional)
      expect_same(resolve_impact(pair.W, pair.u, 0.0, e, rule), newton);
  }
}

TEST(ImpactLaw, PathRulesTendToNewtonsAsFrictionVanishes) {
  Random random(3);
  for (int i = 0; i < kCases; ++i) {
    SCOPED_TRACE(i);
    const BodyPair pair = test::random_pair(random);
    const Vector3d p = resolve_impact(pair.W, pair.u, 0.0, 0.5, ImpactRule::kNewton).impulse;
    for (const ImpactRule rule : {ImpactRule::kPoisson, ImpactRule::kStronge})
      EXPECT_LT((resolve_impact(pair.W, pair.u, 1e-14, 0.5, rule).impulse - p).norm(), 1e-12 * p.norm());
  }
}

TEST(ImpactLaw, RulesAgreeWhereSlipNeverChangesItsDirection) {
  // A sphere: no coupling. It slides throughout if mu (1 + e) abs(u_n) / W_nn stops less than the slip.
  const Matrix3d W = Vector3d(1.0, 3.5, 3.5).asDiagonal();
  const Vector3d u(-1.0, 3.0, -4.0), expected(1.6, -0.3 * 1.6 * 0.6, 0.3 * 1.6 * 0.8);
  for (const ImpactRule rule : kFrictional) {
    const ImpactResult impact = resolve_impact(W, u, 0.3, 0.6, rule);
    EXPECT_LT((impact.impulse - expected).norm(), 1e-15);
    EXPECT_EQ(impact.slip, Slip::kThroughout);
    EXPECT_EQ(impact.steps, 0);
  }
}

TEST(ImpactLaw, WorkOfRestitutionIsTheGivenPartOfThatOfCompression) {
  Random random(4);
  for (int i = 0; i < kCases; ++i) {
    SCOPED_TRACE(i);
    const BodyPair pair = test::random_pair(random);
    const double e = test::random_restitution(random);
    const ImpactResult impact = resolve_impact(pair.W, pair.u, test::random_friction(random), e);
    EXPECT_NEAR(impact.restitution_work, -e * e * impact.compression_work, -1e-14 * impact.compression_work);
  }
}

TEST(ImpactLaw, ScalesWithVelocityAndMassBitwise) {
  Random random(5);
  for (int i = 0; i < kCases; ++i) {
    const BodyPair pair = test::random_pair(random);
    const ImpactResult impact = resolve_impact(pair.W, pair.u, 0.6, 0.4);
    const ImpactResult scaled = resolve_impact(0x1p-300 * pair.W, 0x1p-200 * pair.u, 0.6, 0.4);
    EXPECT_EQ(scaled.impulse, 0x1p100 * impact.impulse);
    EXPECT_EQ(scaled.velocity, 0x1p-200 * impact.velocity);
  }
}

TEST(ImpactLaw, DoesNotDependOnTheChoiceOfTangents) {
  Random random(6);
  for (int i = 0; i < kCases; ++i) {
    SCOPED_TRACE(i);
    const BodyPair pair = test::random_pair(random);
    const Matrix3d turn = Eigen::AngleAxisd(random.uniform(-3.0, 3.0), Vector3d::UnitX()).toRotationMatrix();
    const double friction = test::random_friction(random);
    Matrix3d W = turn * pair.W * turn.transpose();
    W = 0.5 * (W + W.transpose()).eval();
    const Vector3d p = turn * resolve_impact(pair.W, pair.u, friction, 0.5).impulse;
    EXPECT_LT((resolve_impact(W, turn * pair.u, friction, 0.5).impulse - p).norm(), 1e-9 * p.norm());
  }
}

TEST(ImpactLaw, InfiniteFrictionIsTheLimitOfLargeFriction) {
  Random random(7);
  for (int i = 0; i < kCases; ++i) {
    SCOPED_TRACE(i);
    const BodyPair pair = test::random_pair(random);
    const ImpactResult limit = resolve_impact(pair.W, pair.u, kInfinity, 0.5);
    const ImpactResult large = resolve_impact(pair.W, pair.u, 1e9, 0.5);
    EXPECT_EQ(limit.slip, large.slip);
    EXPECT_LT((limit.impulse - large.impulse).norm(), 1e-6 * limit.impulse.norm());
  }
}

TEST(ImpactLaw, InfiniteFrictionWithoutSlipSticks) {
  Random random(8);
  for (int i = 0; i < kCases; ++i) {
    const BodyPair pair = test::random_pair(random);
    const Vector3d u(pair.u[0], 0.0, 0.0);
    const ImpactResult impact = resolve_impact(pair.W, u, kInfinity, 0.5);
    EXPECT_LT((impact.velocity - Vector3d(-0.5 * u[0], 0.0, 0.0)).norm(), 1e-12 * u.norm());
  }
}

// Coordinates that a planar scene masks leave rows of zeros in W.
TEST(ImpactLaw, ClosedDirectionChangesNothing) {
  Random random(9);
  for (int i = 0; i < kCases; ++i) {
    Matrix3d W = rod_inverse_mass(random.uniform(0.1, 1.5)), open = W;
    W.row(2).setZero();
    W.col(2).setZero();
    const Vector3d u(-1.0, random.uniform(-3.0, 3.0), 0.0);
    const double friction = random.uniform(0.01, 2.0);
    for (const ImpactRule rule : kFrictional)
      EXPECT_LT((resolve_impact(W, u, friction, 0.5, rule).velocity -
                 resolve_impact(open, u, friction, 0.5, rule).velocity)
                    .norm(),
                1e-13);
  }
}

TEST(ImpactLaw, BodyThatCanOnlyMoveAlongOneLineJamsByName) {
  // Held at a pivot: u_t = -2 u_n. Sliding stops at the end of compression, friction >= 1/2 holds it there.
  const Vector3d line(1.0, -2.0, 0.0);
  const Matrix3d W = line * line.transpose();
  const ImpactResult stuck = resolve_impact(W, -line, 0.6, 0.5);
  EXPECT_EQ(stuck.status, StatusCode::kSingular);
  EXPECT_LT(stuck.velocity.norm(), 1e-14);
  const ImpactResult free = resolve_impact(W, -line, 0.4, 0.5);
  EXPECT_EQ(free.status, StatusCode::kOk);
  EXPECT_GT(free.velocity[0], 0.1);
}

TEST(ImpactLaw, InfiniteFrictionAgainstAClosedDirectionIsSingularByName) {
  const Matrix3d W = Vector3d(1.0, 2.0, 0.0).asDiagonal();
  const ImpactResult impact = resolve_impact(W, {-1.0, 0.3, 0.1}, kInfinity, 0.5);
  EXPECT_EQ(impact.status, StatusCode::kSingular);
  EXPECT_TRUE(impact.impulse.allFinite() && impact.velocity.allFinite());
}

// Without coupling u_n' = -e u_n whatever the slip does. A slip that one direction alone brakes is an entire
// function of tau, its speed is not: the step must respect both.
TEST(ImpactLaw, ApproachIsRepaidExactlyWithoutCoupling) {
  Random random(11);
  int turning = 0;
  for (int i = 0; i < 2000; ++i) {
    SCOPED_TRACE(i);
    const Matrix3d W =
        Vector3d(std::pow(10.0, random.uniform(-2.0, 2.0)), 1.0, 2.0 * random.below(2)).asDiagonal();
    const Vector3d u(-1.0, std::pow(10.0, random.uniform(-15.0, 2.0)),
                     std::pow(10.0, random.uniform(-15.0, 2.0)));
    const double friction = std::pow(10.0, random.uniform(-12.0, 3.0)), e = test::random_restitution(random);
    const ImpactResult impact = resolve_impact(W, u, friction, e);
    EXPECT_NEAR(impact.velocity[0], e, 1e-12 * u.norm());  // 2e-14
    turning += impact.steps > 0;
  }
  EXPECT_GT(turning, 1000);
}

// Notes D5(b).
TEST(ImpactLaw, SlenderRodHasItsFirstParadoxAtFourThirds) {
  EXPECT_NEAR(critical_friction(rod_inverse_mass(std::atan(2.0))), 4.0 / 3.0, 1e-9);  // 2e-16
  double least = kInfinity, at = 0.0;
  for (int i = 1; i < 100000; ++i) {
    const double angle = 0.5 * std::numbers::pi * i / 100000;
    const double value = critical_friction(rod_inverse_mass(angle));
    if (value < least) least = value, at = angle;
  }
  EXPECT_NEAR(least, 4.0 / 3.0, 1e-9);  // 3e-11 above, by the spacing of the angles
  EXPECT_GE(least, 4.0 / 3.0 - 1e-15);
  EXPECT_NEAR(std::tan(at), 2.0, 1e-4);
}

TEST(ImpactLaw, MarginIsNegativeBeyondTheCriticalFrictionForOneDirectionOnly) {
  const Matrix3d W = rod_inverse_mass(std::atan(2.0));
  const Vector2d with = W.bottomLeftCorner<2, 1>();
  EXPECT_GT(painleve_margin(W, 1.33, with), 0.0);
  EXPECT_LT(painleve_margin(W, 1.34, with), 0.0);
  EXPECT_GT(painleve_margin(W, 1.34, -with), 0.0);
  EXPECT_EQ(critical_friction(Matrix3d::Identity()), kInfinity);
}

TEST(ImpactLaw, JammedSlidingIsAnImpactWithoutCollision) {
  const Matrix3d W = rod_inverse_mass(std::atan(2.0));
  const double towards = W(0, 1) > 0.0 ? 1.0 : -1.0;
  const ImpactResult impact = resolve_tangential_impact(W, {0.0, towards, 0.0}, 2.0, 0.5);
  EXPECT_TRUE(impact.jammed);
  EXPECT_EQ(impact.slip, Slip::kStopped);
  EXPECT_GT(impact.impulse[0], 0.1);
  EXPECT_GT(impact.velocity[0], 0.1);
  EXPECT_LT(impact.energy_change, 0.0);
  EXPECT_EQ(resolve_tangential_impact(W, {0.0, -towards, 0.0}, 2.0, 0.5).slip, Slip::kNone);
  EXPECT_EQ(resolve_tangential_impact(W, {0.0, towards, 0.0}, 1.3, 0.5).slip, Slip::kNone);
  EXPECT_EQ(resolve_tangential_impact(W, Vector3d::Zero(), 2.0, 0.5).slip, Slip::kNone);
}

// In the plane a slip with a negative margin is always one that Newton's rule can stop; in space it is not.
TEST(ImpactLaw, NaiveRuleRefusesWhereSlidingDrawsTheBodiesTogether) {
  Random random(10);
  int refused = 0;
  for (int i = 0; i < 20000; ++i) {
    SCOPED_TRACE(i);
    const BodyPair pair = test::random_pair(random);
    const double friction = random.uniform(1.0, 5.0);
    const ImpactResult naive = resolve_impact(pair.W, pair.u, friction, 0.5, ImpactRule::kNaive);
    if (naive.status == StatusCode::kOk) continue;
    ++refused;
    EXPECT_EQ(naive.status, StatusCode::kRefused);
    EXPECT_EQ(naive.velocity, pair.u);
    EXPECT_LT(painleve_margin(pair.W, friction, pair.u.tail<2>()), 0.0);
    const ImpactResult impact = resolve_impact(pair.W, pair.u, friction, 0.5);
    EXPECT_TRUE(impact.jammed && impact.status == StatusCode::kOk);
    EXPECT_GT(impact.velocity[0], 0.0);
  }
  EXPECT_GT(refused, 4);  // 8
}

TEST(ImpactLaw, MisuseIsNamed) {
  const Matrix3d W = Matrix3d::Identity();
  const Vector3d u(-1.0, 1.0, 0.0);
  const double nan = std::nan("");
  EXPECT_THROW(resolve_impact(W, u, -0.1, 0.5), MisuseError);
  EXPECT_THROW(resolve_impact(W, u, nan, 0.5), MisuseError);
  EXPECT_THROW(resolve_impact(W, u, 0.1, 1.1), MisuseError);
  EXPECT_THROW(resolve_impact(W, u, 0.1, nan), MisuseError);
  EXPECT_THROW(resolve_impact(W, {nan, 0.0, 0.0}, 0.1, 0.5), MisuseError);
  EXPECT_THROW(resolve_impact(nan * W, u, 0.1, 0.5), MisuseError);
  EXPECT_THROW(resolve_impact(-W, u, 0.1, 0.5), MisuseError);
  EXPECT_THROW(resolve_impact(Vector3d(1.0, 1.0, -0.1).asDiagonal(), u, 0.1, 0.5), MisuseError);
  EXPECT_THROW(resolve_impact(Matrix3d::Ones() + Matrix3d(Vector3d(-0.5, 0, 0).asDiagonal()), u, 0.1, 0.5),
               MisuseError);
  EXPECT_THROW(resolve_impact(W, u, 0.1, 0.5, ImpactRule::kNewton), MisuseError);
  EXPECT_THROW(resolve_tangential_impact(W, u, 0.1, 0.5), MisuseError);
  EXPECT_THROW(painleve_margin(W, 0.1, Vector2d::Zero()), MisuseError);
}

}  // namespace
}  // namespace feder
