#include "engine/contacts.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include "engine/body.h"
#include "engine/energy.h"
#include "engine/system.h"
#include "tests/support/random.h"

namespace feder {
namespace {

Matrix3d random_rotation(Random& random) {
  return Eigen::Quaterniond(random.uniform(), random.uniform(), random.uniform(), random.uniform())
      .normalized()
      .toRotationMatrix();
}

// A ball, a box and a capsule near a tilted plane and near each other, all moving.
SystemBuilder::Built crowd(std::uint64_t seed) {
  Random random(seed);
  SystemBuilder builder;
  builder.add_collider(builder.add_world_point(random.vector(0.1)), HalfSpaceShape{}, {0.5, 0.0}, 0,
                       Eigen::AngleAxisd(0.3, random.vector().normalized()).toRotationMatrix());
  const MassProperties masses[3] = {solid_sphere("ball", 1.0, 0.3), solid_box("box", 2.0, {0.4, 0.5, 0.6}),
                                    solid_cylinder("capsule", 0.5, 0.2, 0.6)};
  const Shape shapes[3] = {SphereShape{0.3}, BoxShape{{0.2, 0.25, 0.3}}, CapsuleShape{0.2, 0.3}};
  for (int i = 0; i < 3; ++i) {
    const Anchor body =
        builder.add_body(masses[i], {.position = Vector3d(0.55 * i, 0.1 * i, 0.45) + random.vector(0.05),
                                     .orientation = random_rotation(random),
                                     .velocity = random.vector(),
                                     .angular_velocity = random.vector(3.0)});
    builder.add_collider(body, shapes[i], {0.5, 0.0});
  }
  builder.add_collider(builder.add_particle(0.1, {0.25, 0.35, 0.4}, random.vector()), SphereShape{0.05});
  return builder.build();
}

// Points of a box and a capsule may be crossings of edges, which move along both: there u_n is the rate for
// parallel faces only.
TEST(Contacts, NormalVelocityIsTheRateOfTheGap) {
  double worst = 0.0;
  int compared = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const auto [system, state] = crowd(seed);
    ContactFinder finder(system);
    ContactRows rows, ahead, behind;
    finder.find(state, 0.05, rows);
    VectorXd u;
    rows.velocities(state.v, u);
    const double h = 1e-6;
    State moved = state;
    advance(system, h, state.v, state.q, moved.q);
    finder.find(moved, 0.05, ahead);
    advance(system, -h, state.v, state.q, moved.q);
    finder.find(moved, 0.05, behind);
    std::map<std::tuple<int, int, std::uint32_t>, double> gap;
    for (const Contact& c : behind.contacts) gap[c.key()] = c.at.gap;
    for (const Contact& c : ahead.contacts) {
      if (!gap.contains(c.key()) || (c.a == 2 && c.b == 3)) continue;
      for (int i = 0; i < rows.count(); ++i)
        if (rows.contacts[i].key() == c.key()) {
          worst = std::max(worst, std::abs((c.at.gap - gap[c.key()]) / (2.0 * h) - u[3 * i]));
          ++compared;
        }
    }
  }
  EXPECT_GT(compared, 400);
  EXPECT_LT(worst, 2e-7);
}

TEST(Contacts, FramesAreRightHanded) {
  Random random(7);
  for (int i = 0; i < 1000; ++i) {
    Vector3d n = random.vector().normalized();
    if (i < 6) n = (i % 2 ? -1.0 : 1.0) * Vector3d::Unit(i / 2);
    const Matrix3d F = contact_frame(n);
    EXPECT_EQ(Vector3d(F.row(0)), n);
    EXPECT_LT((F * F.transpose() - Matrix3d::Identity()).norm(), 1e-15 * 4);
    EXPECT_GT(F.determinant(), 0.99);
  }
}

TEST(Contacts, ImpulsesAreTheTransposeOfVelocities) {
  const auto [system, state] = crowd(3);
  ContactFinder finder(system);
  ContactRows rows;
  finder.find(state, 0.2, rows);
  ASSERT_GT(rows.count(), 3);
  Random random(1);
  const VectorXd y = random.numbers(3 * rows.count()), v = random.numbers(static_cast<int>(state.v.size()));
  VectorXd u, f = VectorXd::Zero(v.size());
  rows.multiply(v, u);
  rows.add_impulses(y, f);
  EXPECT_NEAR(f.dot(v), y.dot(u), 1e-13);
}

TEST(Contacts, ImpulsesBetweenBodiesKeepMomentum) {
  const auto [system, state] = crowd(5);
  ContactFinder finder(system);
  ContactRows rows;
  finder.find(state, 0.2, rows);
  State after = state;
  int between = 0;
  for (int i = 0; i < rows.count(); ++i) {
    if (system.colliders[rows.contacts[i].a].fixed) continue;
    VectorXd y = VectorXd::Zero(3 * rows.count()), f = VectorXd::Zero(state.v.size());
    y.segment<3>(3 * i) = Vector3d(0.3, -0.2, 0.1);
    rows.add_impulses(y, f);
    after.v += system.inverse_mass.cwiseProduct(f);
    ++between;
  }
  ASSERT_GT(between, 0);
  EXPECT_GT((after.v - state.v).norm(), 0.01);
  EXPECT_LT((linear_momentum(system, after) - linear_momentum(system, state)).norm(), 1e-14);
  EXPECT_LT((angular_momentum(system, after) - angular_momentum(system, state)).norm(), 1e-14);
}

// Two balls in touch, however they may be told apart.
int contacts_of_two(int group_a, int group_b, bool joined, bool pinned) {
  SystemBuilder builder;
  Anchor balls[2];
  for (int i = 0; i < 2; ++i) {
    balls[i] = builder.add_body(solid_sphere("ball", 1.0, 0.5), {.position = Vector3d(1.0 * i, 0.0, 0.0),
                                                                 .free = pinned ? kPinned : kFree,
                                                                 .free_spin = pinned ? kPinned : kFree});
    builder.add_collider(balls[i], SphereShape{0.5}, {}, i ? group_b : group_a);
  }
  if (joined) builder.add(AnchorDistanceRow{{balls[0], balls[1], 10.0}, 1.0});
  const auto [system, state] = builder.build();
  ContactFinder finder(system);
  ContactRows rows;
  finder.find(state, 1e-3, rows);
  return rows.count();
}

TEST(Contacts, GroupsJoinedAndFixedPairsPassThroughEachOther) {
  EXPECT_EQ(contacts_of_two(0, 0, false, false), 1);
  EXPECT_EQ(contacts_of_two(1, 2, false, false), 1);
  EXPECT_EQ(contacts_of_two(1, 1, false, false), 0);
  EXPECT_EQ(contacts_of_two(0, 0, true, false), 0);
  EXPECT_EQ(contacts_of_two(0, 0, false, true), 0);
}

TEST(Contacts, BadCollidersAreNamed) {
  SystemBuilder builder;
  const Anchor at = builder.add_particle(1.0, {0, 0, 0});
  const auto message = [&](const Shape& shape, const Surface& surface) -> std::string {
    try {
      builder.add_collider(at, shape, surface);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(message(SphereShape{-1.0}, {}), "collider 0: radius = -1 m, expected a finite number >= 0");
  EXPECT_EQ(message(SphereShape{1.0}, {-0.5, 0.0}),
            "collider 0: friction = -0.5, expected a finite number >= 0");
  EXPECT_EQ(message(SphereShape{1.0}, {0.5, 1.5}),
            "collider 0: restitution = 1.5, expected a value from 0 to 1");
  EXPECT_EQ(message(SphereShape{1.0}, {0.5, std::nan("")}),
            "collider 0: restitution = nan, expected a value from 0 to 1");
  EXPECT_NE(message(TorusShape{0.1, 0.2}, {}).find("major radius = 0.1"), std::string::npos);
  EXPECT_NE(message(BoxShape{{1.0, 0.0, 1.0}}, {}).find("half edge y = 0 m"), std::string::npos);
}

}  // namespace
}  // namespace feder
