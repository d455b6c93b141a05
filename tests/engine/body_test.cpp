// Bodies in a System: where they start, their rows against finite differences along the exponential map, and
// what is refused.
#include "engine/body.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "engine/check.h"
#include "engine/energy.h"
#include "engine/kkt.h"
#include "tests/support/random.h"

namespace feder {
namespace {

using Eigen::MatrixXd;

Matrix3d some_rotation(Random& random) {
  const Vector3d theta = random.vector(2.0);
  return Eigen::AngleAxisd(theta.norm(), theta.normalized()).toRotationMatrix();
}

/// A lump whose principal axes are not its own axes and whose centre is not its origin.
MassProperties lump(Random& random) {
  std::vector<PointMass> points;
  for (int i = 0; i < 6; ++i) points.push_back({random.uniform(0.2, 1.0), random.vector(0.5)});
  return point_masses("lump", points);
}

SystemBuilder::BodyStart some_start(Random& random) {
  return {random.vector(), some_rotation(random), random.vector(), random.vector(3.0)};
}

/// Two bodies, a particle and a world point, joined by every row between anchors.
SystemBuilder::Built joined(std::uint64_t seed, double damping_time = 0.0) {
  Random random(seed);
  SystemBuilder builder;
  const Anchor particle = builder.add_particle(0.7, random.vector()),
               wall = builder.add_world_point(random.vector());
  const Anchor one = builder.add_body(lump(random), some_start(random)),
               two = builder.add_body(lump(random), some_start(random));
  auto at = [&](Anchor body) { return Anchor{.body = body.body, .point = random.vector(0.4)}; };
  for (const auto& [a, b] :
       {std::pair{at(one), at(two)}, std::pair{wall, at(one)}, std::pair{at(two), particle}}) {
    builder.add(BallRow{{a, b, 20.0, damping_time}});
    builder.add(AnchorDistanceRow{{a, b, 30.0, damping_time}, 0.4});
  }
  const Vector3d n = random.vector().normalized(), m = random.vector().normalized();
  builder.add(PerpendicularRow{{at(one), at(two), 10.0, damping_time}, n, m});
  builder.add(PerpendicularRow{{wall, at(two), 10.0, damping_time}, n, m});
  builder.add(AlongRow{{{at(one), at(two), 10.0, damping_time}, 0.1}, n});
  builder.add(AlongRow{{{wall, at(two), 10.0, damping_time}, 0.1}, n});
  builder.add(AlongRow{{{at(one), particle, 10.0, damping_time}, 0.1}, m});
  builder.add(TurnRow{{{at(one), at(two), 10.0, damping_time}, 0.3}, n, n.unitOrthogonal(), m});
  builder.add(TurnRow{{{wall, at(two), 10.0, damping_time}, -0.3}, m, m.unitOrthogonal(), n});
  builder.set_gravity({0.0, -9.81, 0.0});
  return builder.build();
}

VectorXd moved(const System& s, const VectorXd& q, const VectorXd& v, double dt) {
  VectorXd out;
  advance(s, dt, v, q, out);
  return out;
}

TEST(Body, StartsWhereItIsPut) {
  Random random(7);
  SystemBuilder builder;
  builder.add_particle(1.0, {0.0, 0.0, 0.0});
  const MassProperties properties = lump(random);
  const SystemBuilder::BodyStart start = some_start(random);
  const Anchor origin = builder.add_body(properties, start);
  const auto [s, state] = builder.build();
  const Body& b = s.bodies[0];
  EXPECT_LT((position(s, origin, state.q) - start.position).norm(), 1e-14);
  EXPECT_LT((orientation(b, state.q) - start.orientation).norm(), 1e-14);
  EXPECT_LT((angular_velocity(b, state) - start.angular_velocity).norm(), 1e-13);
  const Vector3d point(0.3, -0.2, 0.5);
  EXPECT_LT(
      (position(s, {.body = 0, .point = point}, state.q) - start.position - start.orientation * point).norm(),
      1e-14);
  EXPECT_EQ(s.free_count, 9);
  EXPECT_EQ(state.q.size(), s.position_size());
}

TEST(Body, HasTheEnergyAndMomentumOfItsPoints) {
  Random random(3);
  std::vector<PointMass> points;
  for (int i = 0; i < 7; ++i) points.push_back({random.uniform(0.2, 1.0), random.vector(0.5)});
  SystemBuilder builder;
  builder.add_body(point_masses("points", points), some_start(random));
  const auto [s, state] = builder.build();
  double energy = 0.0;
  Vector3d p = Vector3d::Zero(), L = Vector3d::Zero();
  for (const PointMass& point : points) {
    const Anchor at{.body = 0, .point = point.position};
    const Vector3d x = position(s, at, state.q), v = velocity(s, at, state);
    energy += 0.5 * point.mass * v.squaredNorm();
    p += point.mass * v;
    L += point.mass * x.cross(v);
  }
  ASSERT_GT(L.norm(), 0.1);
  EXPECT_NEAR(kinetic_energy(s, state) / energy, 1.0, 1e-13);
  EXPECT_LT((linear_momentum(s, state) - p).norm(), 1e-13 * p.norm());
  EXPECT_LT((angular_momentum(s, state) - L).norm(), 1e-13 * L.norm());
}

TEST(AnchorRows, VelocityOfAnAnchorIsTheDerivativeOfItsPosition) {
  const auto [s, state] = joined(1);
  const Anchor at{.body = 1, .point = {0.2, -0.3, 0.1}};
  constexpr double kStep = 1e-6;
  const Vector3d rate = (position(s, at, moved(s, state.q, state.v, kStep)) -
                         position(s, at, moved(s, state.q, state.v, -kStep))) /
                        (2.0 * kStep);
  EXPECT_LT((velocity(s, at, state) - rate).norm(), 1e-9);
}

TEST(AnchorRows, JacobianIsTheDerivativeOfPhiAlongTheExponentialMap) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const auto [s, state] = joined(seed);
    Random random(seed);
    VectorXd v = state.v, Jv, after, before;
    for (double& x : v) x = random.uniform(-1.0, 1.0);
    for (int i : s.masked) v[i] = 0.0;
    Kkt kkt;
    kkt.prepare(s);
    ASSERT_TRUE(kkt.evaluate(state.q).ok());
    kkt.multiply_jacobian(v, Jv);
    constexpr double kStep = 1e-5;
    evaluate_phi(s, moved(s, state.q, v, kStep), after);
    evaluate_phi(s, moved(s, state.q, v, -kStep), before);
    ASSERT_GT(Jv.norm(), 0.1);
    EXPECT_LT((Jv - (after - before) / (2.0 * kStep)).norm(), 1e-8 * Jv.norm()) << seed;  // 1e-10
  }
}

TEST(AnchorRows, GeometricStiffnessIsTheSecondDerivativeAlongTheExponentialMap) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const auto [s, state] = joined(seed);
    Random random(seed + 50);
    VectorXd v = state.v, lambda(s.rows), Kv, phi;
    for (double& x : v) x = random.uniform(-1.0, 1.0);
    for (int i : s.masked) v[i] = 0.0;
    for (double& x : lambda) x = random.uniform(-5.0, 5.0);
    Kkt kkt;
    kkt.prepare(s);
    kkt.set_step(1.0, 1.0);
    ASSERT_TRUE(kkt.evaluate(state.q).ok());
    kkt.set_geometric_stiffness(GeometricStiffness::kFull, 1.0, state, lambda);
    Kv = VectorXd::Zero(v.size());
    kkt.add_geometric(v, Kv);
    auto along = [&](double step) {
      evaluate_phi(s, moved(s, state.q, v, step), phi);
      return lambda.dot(phi);
    };
    constexpr double kStep = 1e-4;
    const double second = (along(kStep) - 2.0 * along(0.0) + along(-kStep)) / (kStep * kStep);
    ASSERT_GT(std::abs(second), 0.1);
    EXPECT_NEAR(-v.dot(Kv), second, 1e-5 * lambda.norm()) << seed;
  }
}

TEST(AnchorRows, ForcesAreMinusTheGradientOfTheEnergy) {
  const auto [s, state] = joined(4);
  VectorXd f;
  ASSERT_TRUE(evaluate_undamped_forces(s, state, f).ok());
  auto energy = [&](int i, double step) {
    VectorXd direction = VectorXd::Zero(state.v.size());
    direction[i] = 1.0;
    const State at{0.0, moved(s, state.q, direction, step), state.v};
    return row_energy(s, at) + external_energy(s, at);
  };
  for (int i = 0; i < state.v.size(); ++i) {
    if (s.inverse_mass[i] == 0.0) continue;
    constexpr double kStep = 1e-5;
    EXPECT_NEAR(f[i], -(energy(i, kStep) - energy(i, -kStep)) / (2.0 * kStep), 1e-7 * f.norm()) << i;
  }
}

TEST(AnchorRows, InternalRowsGiveNoMomentum) {
  Random random(9);
  SystemBuilder builder;
  const Anchor one = builder.add_body(lump(random), some_start(random)),
               two = builder.add_body(lump(random), some_start(random));
  builder.add(BallRow{{{.body = one.body, .point = {0.1, 0.2, 0.3}},
                       {.body = two.body, .point = {-0.2, 0.1, 0.4}},
                       50.0,
                       0.1}});
  builder.add(PerpendicularRow{{one, two, 10.0, 0.1}});
  const auto [s, state] = builder.build();
  VectorXd f;
  ASSERT_TRUE(evaluate_forces(s, state, f).ok());
  ASSERT_GT(f.norm(), 1.0);
  Vector3d force = Vector3d::Zero(), torque = Vector3d::Zero();
  for (const Body& b : s.bodies) {
    const Vector3d F = f.segment<3>(3 * b.centre), x = state.q.segment<3>(3 * b.centre);
    force += F;
    torque += x.cross(F) + rotation_matrix(state.q.data() + b.quaternion) * f.segment<3>(3 * b.spin);
  }
  EXPECT_LT(force.norm(), 1e-13 * f.norm());
  // the perpendicular row is a pure couple, the ball acts at two places: its couple vanishes only where they
  // meet
  const Vector3d gap = position(s, {.body = 1, .point = {-0.2, 0.1, 0.4}}, state.q) -
                       position(s, {.body = 0, .point = {0.1, 0.2, 0.3}}, state.q);
  VectorXd phi;
  evaluate_phi(s, state.q, phi);
  const Vector3d along = f.segment<3>(3 * s.bodies[1].centre);
  EXPECT_LT((torque - gap.cross(along)).norm(), 1e-12 * f.norm());
}

template <class Add>
std::string message(Add&& add) {
  SystemBuilder builder;
  try {
    add(builder);
    (void)builder.build();
  } catch (const InputError& e) {
    return e.what();
  }
  return "accepted";
}

TEST(BodyInput, IsRefusedByName) {
  const MassProperties box = solid_box("box", 1.0, {0.1, 0.2, 0.3});
  MassProperties unphysical = box;
  unphysical.inertia(0, 0) = 10.0;
  const auto says = [](const std::string& text, const char* part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_TRUE(says(message([&](auto& b) { b.add_body(unphysical, {}); }), "body 0"));
  EXPECT_TRUE(says(message([&](auto& b) { b.add_body(box, {.orientation = 2.0 * Matrix3d::Identity()}); }),
                   "proper rotation"));
  EXPECT_TRUE(says(message([&](auto& b) {
                     b.add_body(box, {.angular_velocity = {0, 0, 1}, .free_spin = 3});
                   }),
                   "masked"));
  EXPECT_TRUE(says(message([&](auto& b) {
                     const Anchor a = b.add_body(box, {});
                     b.add(BallRow{{a, {.body = 4}, 1.0}});
                   }),
                   "an existing body"));
  EXPECT_TRUE(says(message([&](auto& b) {
                     const Anchor a = b.add_body(box, {});
                     b.add(BallRow{{a, a, 1.0}});
                   }),
                   "two different"));
  EXPECT_TRUE(says(message([&](auto& b) {
                     const Anchor a = b.add_body(box, {});
                     b.add_distance(a, b.add_particle(1.0, {1, 0, 0}), {1.0});
                   }),
                   "a particle or world point"));
}

}  // namespace
}  // namespace feder
