// Two bodies that touch (notes D1-D4): balances of the impulse, and the sign that the notes print wrong.
#include "solvers/contact/body_contact.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "engine/check.h"
#include "solvers/contact/impact_law.h"
#include "tests/solvers/random_impact.h"

namespace feder {
namespace {

using test::BodyPair;

constexpr int kCases = 200;

/// Two bodies, neither stationary.
BodyPair moving_pair(Random& random, double spread = 1.0) {
  for (;;) {
    const BodyPair pair = test::random_pair(random, spread);
    if (pair.a.inverse_mass > 0.0) return pair;
  }
}

struct After {
  BodyVelocity a, b;
};

After apply(const BodyPair& pair, const Vector3d& impulse) {
  const Vector3d p = pair.axes * impulse;
  return {after_impulse(pair.a, pair.velocity_a, -p), after_impulse(pair.b, pair.velocity_b, p)};
}

Vector3d velocity(const BodyPair& pair, const After& after) {
  return contact_velocity(pair.a, after.a, pair.b, after.b, pair.axes);
}

Vector3d spin(const ContactBody& body, const BodyVelocity& v) {
  return body.inverse_inertia.inverse() * v.angular;
}

/// About the point of contact.
Vector3d angular_momentum(const ContactBody& body, const BodyVelocity& v) {
  return spin(body, v) - body.arm.cross(v.linear) / body.inverse_mass;
}

TEST(BodyContact, AxesAreARotationWhoseFirstColumnIsTheNormal) {
  Random random(1);
  for (int i = 0; i < kCases; ++i) {
    const Vector3d n = i < 3 ? Vector3d(Vector3d::Unit(i)) : random.vector().normalized();
    const Matrix3d axes = contact_axes(n);
    EXPECT_LT((axes.transpose() * axes - Matrix3d::Identity()).norm(), 1e-15);
    EXPECT_NEAR(axes.determinant(), 1.0, 1e-15);
    EXPECT_LT((axes.col(0) - n).norm(), 1e-15);
  }
}

TEST(BodyContact, InverseMassTimesImpulseIsTheChangeOfContactVelocity) {
  Random random(2);
  for (int i = 0; i < kCases; ++i) {
    SCOPED_TRACE(i);
    const BodyPair pair = test::random_pair(random);
    const Vector3d p = random.vector(), change = pair.W * p;
    const double size = pair.u.norm() + change.norm();
    EXPECT_LT((velocity(pair, apply(pair, p)) - pair.u - change).norm(), 1e-13 * size);  // 2e-15
  }
}

TEST(BodyContact, TotalMomentumStaysAndSpinAloneDoesNot) {
  Random random(3);
  double worst = 0.0, spin_change = 0.0;
  for (int i = 0; i < kCases; ++i) {
    const BodyPair pair = moving_pair(random, 0.3);
    const Vector3d p = resolve_impact(pair.W, pair.u, 0.5, 0.5).impulse;
    const After after = apply(pair, p);
    const auto linear = [&](const BodyVelocity& a, const BodyVelocity& b) -> Vector3d {
      return a.linear / pair.a.inverse_mass + b.linear / pair.b.inverse_mass;
    };
    worst = std::max(worst, (linear(after.a, after.b) - linear(pair.velocity_a, pair.velocity_b)).norm() /
                                (p.norm() + linear(after.a, after.b).norm()));
    const auto change = [&](auto&& of) -> Vector3d {
      return of(pair.a, after.a) + of(pair.b, after.b) - of(pair.a, pair.velocity_a) -
             of(pair.b, pair.velocity_b);
    };
    const double size = spin(pair.a, pair.velocity_a).norm() + spin(pair.b, pair.velocity_b).norm() +
                        p.norm() * (pair.a.arm.norm() + pair.b.arm.norm());
    worst = std::max(worst, change(angular_momentum).norm() / size);
    spin_change = std::max(spin_change, change(spin).norm() / size);
  }
  EXPECT_LT(worst, 1e-14) << worst;
  EXPECT_GT(spin_change, 0.18) << spin_change;
}

TEST(BodyContact, MeasuredRestitutionIsTheOneAskedFor) {
  Random random(4);
  for (int i = 0; i < kCases; ++i) {
    SCOPED_TRACE(i);
    const BodyPair pair = test::random_pair(random);
    const double e = random.uniform(0.0, 1.0);
    const Vector3d p = resolve_impact(pair.W, pair.u, 0.0, e, ImpactRule::kNewton).impulse;
    EXPECT_NEAR(velocity(pair, apply(pair, p))[0] / -pair.u[0], e, 1e-12);
  }
}

// Slip 6: "- (w2 - I2^-1 (r2 x p n)) x r2" turns the last term of the denominator round.
TEST(BodyContact, RestitutionIsMissedWithTheSignAsPrinted) {
  Random random(5);
  double worst = 0.0;
  for (int i = 0; i < kCases; ++i) {
    const BodyPair pair = moving_pair(random);
    const Vector3d n = pair.axes.col(0);
    const auto turning = [&](const ContactBody& body) {
      return body.arm.cross(n).dot(body.inverse_inertia * body.arm.cross(n));
    };
    const double sum = pair.a.inverse_mass + pair.b.inverse_mass + turning(pair.a);
    EXPECT_NEAR((sum + turning(pair.b)) / pair.W(0, 0), 1.0, 1e-12);
    const Vector3d p(-1.5 * pair.u[0] / (sum - turning(pair.b)), 0.0, 0.0);
    worst = std::max(worst, std::abs(velocity(pair, apply(pair, p))[0] / -pair.u[0] - 0.5));
  }
  EXPECT_GT(worst, 2.0);
}

TEST(BodyContact, WithoutFrictionTheEnergyOfTheBodiesFallsByTheFormula) {
  Random random(6);
  for (int i = 0; i < kCases; ++i) {
    SCOPED_TRACE(i);
    const BodyPair pair = moving_pair(random);
    const double e = random.uniform(0.0, 1.0);
    const ImpactResult impact = resolve_impact(pair.W, pair.u, 0.0, e, ImpactRule::kNewton);
    const After after = apply(pair, impact.impulse);
    const double before =
        test::kinetic_energy(pair.a, pair.velocity_a) + test::kinetic_energy(pair.b, pair.velocity_b);
    const double change =
        test::kinetic_energy(pair.a, after.a) + test::kinetic_energy(pair.b, after.b) - before;
    const double expected = -(1.0 - e * e) * pair.u[0] * pair.u[0] / (2.0 * pair.W(0, 0));
    EXPECT_NEAR(change, expected, 1e-12 * before);
    EXPECT_NEAR(impact.energy_change, expected, 1e-14 * before);
  }
}

TEST(BodyContact, VeryHeavyPartnerIsTheStationaryOne) {
  Random random(7);
  for (int i = 0; i < kCases; ++i) {
    SCOPED_TRACE(i);
    BodyPair pair = moving_pair(random);
    pair.velocity_a = {};
    if (contact_velocity({}, {}, pair.b, pair.velocity_b, pair.axes)[0] > 0.0)
      pair.velocity_b = {-pair.velocity_b.linear, -pair.velocity_b.angular};
    pair.a = {1e-12, 1e-12 * Matrix3d::Identity(), pair.a.arm};
    const Matrix3d heavy = contact_inverse_mass(pair.a, pair.b, pair.axes);
    const Matrix3d stationary = contact_inverse_mass({}, pair.b, pair.axes);
    const Vector3d u = contact_velocity({}, {}, pair.b, pair.velocity_b, pair.axes);
    const Vector3d p = resolve_impact(heavy, u, 0.4, 0.6).impulse;
    EXPECT_GT((heavy - stationary).norm(), 0.0);
    EXPECT_LT((resolve_impact(stationary, u, 0.4, 0.6).impulse - p).norm(), 1e-9 * p.norm());
  }
}

TEST(BodyContact, StationaryPartnerDoesNotMove) {
  const BodyVelocity after = after_impulse({}, {}, Vector3d(1.0, 2.0, 3.0));
  EXPECT_EQ(after.linear, Vector3d::Zero());
  EXPECT_EQ(after.angular, Vector3d::Zero());
}

TEST(BodyContact, MisuseIsNamed) {
  EXPECT_THROW(contact_axes(Vector3d(1.0, 1.0, 0.0)), MisuseError);
  EXPECT_THROW(contact_axes(Vector3d::Zero()), MisuseError);
  EXPECT_THROW(contact_inverse_mass({-1.0}, {}, Matrix3d::Identity()), MisuseError);
  EXPECT_THROW(contact_inverse_mass({std::nan("")}, {}, Matrix3d::Identity()), MisuseError);
}

}  // namespace
}  // namespace feder
