// Joints leave the freedoms they promise; dials count turns; driven nodes move; what is refused.
#include "engine/joints.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "engine/check.h"
#include "engine/kkt.h"
#include "tests/support/random.h"

namespace feder {
namespace {

using Eigen::MatrixXd;
constexpr double kPi = std::numbers::pi;

MassProperties brick() {
  return solid_box("brick", 1.2, {0.5, 0.3, 0.1});
}

/// Two bricks at random poses.
struct Pair {
  explicit Pair(std::uint64_t seed = 1) {
    Random random(seed);
    for (Anchor* body : {&a, &b}) {
      const Vector3d theta = random.vector(2.0);
      *body = builder.add_body(
          brick(), {.position = random.vector(),
                    .orientation = Eigen::AngleAxisd(theta.norm(), theta.normalized()).toRotationMatrix()});
    }
    place = random.vector();
    axis = random.vector();
  }
  SystemBuilder builder;
  Anchor a, b;
  Vector3d place, axis;
};

MatrixXd dense_jacobian(const System& s, const VectorXd& q) {
  Kkt kkt;
  kkt.prepare(s);
  EXPECT_TRUE(kkt.evaluate(q).ok());
  MatrixXd J(s.rows, 3 * s.nodes);
  VectorXd column;
  for (int i = 0; i < 3 * s.nodes; ++i) {
    kkt.multiply_jacobian(VectorXd::Unit(3 * s.nodes, i), column);
    J.col(i) = column;
  }
  return J;
}

struct Promise {
  const char* name;
  void (*add)(Pair&);
  int freedoms;
};

class JointFreedoms : public testing::TestWithParam<Promise> {};

TEST_P(JointFreedoms, AreThePromisedOnesAndTheJointStartsClosed) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Pair pair(seed);
    GetParam().add(pair);
    const auto [s, state] = pair.builder.build();
    VectorXd phi;
    evaluate_phi(s, state.q, phi);
    EXPECT_LT(phi.cwiseAbs().maxCoeff(), 1e-14);
    const MatrixXd J = dense_jacobian(s, state.q);
    Eigen::JacobiSVD<MatrixXd> svd(J);
    svd.setThreshold(1e-9);
    EXPECT_EQ(svd.rank(), J.rows()) << "dependent rows";
    EXPECT_EQ(6 - svd.rank(), GetParam().freedoms);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Joints, JointFreedoms,
    testing::Values(
        Promise{"ball", [](Pair& p) { add_ball(p.builder, p.a, p.b, p.place); }, 3},
        Promise{"universal",
                [](Pair& p) { add_universal(p.builder, p.a, p.b, p.place, p.axis, p.axis.unitOrthogonal()); },
                2},
        Promise{"hinge", [](Pair& p) { add_hinge(p.builder, p.a, p.b, p.place, p.axis); }, 1},
        Promise{"cylindrical", [](Pair& p) { add_cylindrical(p.builder, p.a, p.b, p.place, p.axis); }, 2},
        Promise{"prismatic", [](Pair& p) { add_prismatic(p.builder, p.a, p.b, p.place, p.axis); }, 1},
        Promise{"weld", [](Pair& p) { add_weld(p.builder, p.a, p.b, p.place); }, 0}),
    [](const auto& joint) { return std::string(joint.param.name); });

/// Gaps of a joint after b has moved against a by a screw about (or along) the joint's axis.
double gap_after(void (*add)(Pair&), double angle, double way) {
  Pair pair(5);
  const Vector3d axis = pair.axis.normalized();
  add(pair);
  auto [s, state] = pair.builder.build();
  const Body& b = s.bodies[1];
  const Eigen::AngleAxisd turn(angle, axis);
  const Matrix3d R = turn * rotation_matrix(state.q.data() + b.quaternion);
  const Eigen::Quaterniond quaternion(R);
  const Vector3d centre = state.q.segment<3>(3 * b.centre);
  state.q.segment<3>(3 * b.centre) = pair.place + turn * (centre - pair.place) + way * axis;
  state.q.segment<4>(b.quaternion) << quaternion.w(), quaternion.x(), quaternion.y(), quaternion.z();
  VectorXd phi;
  evaluate_phi(s, state.q, phi);
  return phi.cwiseAbs().maxCoeff();
}

TEST(JointRows, LetTheirOwnMotionPassAndNoOther) {
  auto hinge = [](Pair& p) { add_hinge(p.builder, p.a, p.b, p.place, p.axis); };
  auto prismatic = [](Pair& p) { add_prismatic(p.builder, p.a, p.b, p.place, p.axis); };
  auto cylindrical = [](Pair& p) { add_cylindrical(p.builder, p.a, p.b, p.place, p.axis); };
  EXPECT_LT(gap_after(hinge, 1.3, 0.0), 1e-14);
  EXPECT_GT(gap_after(hinge, 0.0, 0.1), 0.05);
  EXPECT_LT(gap_after(prismatic, 0.0, 0.7), 1e-14);
  EXPECT_GT(gap_after(prismatic, 0.1, 0.0), 0.05);
  EXPECT_LT(gap_after(cylindrical, -2.1, 0.7), 1e-14);
}

TEST(TurnRow, CountsTurns) {
  Pair pair;
  add_hinge(pair.builder, pair.a, pair.b, pair.place, pair.axis);
  add_turn(pair.builder, pair.a, pair.b, pair.axis, {1.0}, 0.5);
  auto [s, state] = pair.builder.build();
  const TurnRow& row = std::get<std::vector<TurnRow>>(s.stencil_rows)[0];
  EXPECT_NEAR(row.angle(state.q.data()), 0.0, 1e-14);
  const Body& b = s.bodies[1];
  VectorXd v = VectorXd::Zero(3 * s.nodes);
  const Vector3d axis = pair.axis.normalized();
  constexpr int kSteps = 100;
  for (int n = 0; n < kSteps; ++n) {  // five turns
    v.segment<3>(3 * b.spin) = rotation_matrix(state.q.data() + b.quaternion).transpose() * axis;
    advance(s, 10.0 * kPi / kSteps, v, state.q, state.q);
    place_driven_nodes(s, 0.0, state.q);
  }
  EXPECT_NEAR(row.angle(state.q.data()), 10.0 * kPi, 1e-12);
  VectorXd phi;
  evaluate_phi(s, state.q, phi);
  EXPECT_NEAR(phi[s.row_of_id.back()], 10.0 * kPi - 0.5, 1e-12);
}

TEST(Drive, MovesItsNodeAndGivesRowsTheirTimeDerivative) {
  SystemBuilder builder;
  const Anchor hand = builder.add_moving_point({[](double t) { return Vector3d(std::sin(t), t * t, 1.0); },
                                                [](double t) { return Vector3d(std::cos(t), 2.0 * t, 0.0); },
                                                [](double t) { return Vector3d(-std::sin(t), 2.0, 0.0); }});
  const Anchor ball = builder.add_particle(1.0, {0.3, -1.0, 0.2}, {0.5, 0.1, -0.7});
  builder.add_distance(hand, ball, {10.0}, 1.0);
  const Anchor body = builder.add_body(brick(), {.position = {0.0, 2.0, 0.0}, .angular_velocity = {1, 2, 3}});
  add_turn(
      builder, {}, body, Vector3d::UnitY(), {1.0},
      Target{[](double t) { return std::sin(2.0 * t); }, [](double t) { return 2.0 * std::cos(2.0 * t); },
             [](double t) { return -4.0 * std::sin(2.0 * t); }});
  const auto [s, start] = builder.build();
  auto at = [&](double t) {
    State state = start;
    advance(s, t, start.v, start.q, state.q);
    state.t = t;
    place_driven_nodes(s, t, state.q);
    return state;
  };
  Kkt kkt;
  kkt.prepare(s);
  State state = at(0.4);
  set_driven_velocities(s, state.t, state.v);
  ASSERT_TRUE(kkt.evaluate(state.q).ok());
  VectorXd rate, after, before;
  kkt.multiply_jacobian(state.v, rate);
  constexpr double kStep = 2e-6;
  evaluate_phi(s, at(0.4 + kStep).q, after);
  evaluate_phi(s, at(0.4 - kStep).q, before);
  ASSERT_GT(rate.norm(), 0.5);
  EXPECT_LT((rate - (after - before) / (2.0 * kStep)).norm(), 1e-8);  // 1e-9
}

template <class Add>
std::string message(Add&& add) {
  Pair pair;
  try {
    add(pair);
    (void)pair.builder.build();
  } catch (const InputError& e) {
    return e.what();
  }
  return "accepted";
}
bool says(const std::string& text, const char* part) {
  return text.find(part) != std::string::npos;
}

TEST(JointInput, IsRefusedByName) {
  EXPECT_TRUE(says(message([](Pair& p) { add_hinge(p.builder, p.a, p.b, p.place, Vector3d::Zero()); }),
                   "length of its axis"));
  EXPECT_TRUE(says(message([](Pair& p) {
                     add_ball(p.builder, p.a, p.b, p.place, {.linear = {kRigid, 0.0, 2.0}});
                   }),
                   "0 where the stiffness is infinite"));
  EXPECT_TRUE(says(message([](Pair& p) { p.builder.add_moving_point({}); }), "acceleration"));
  EXPECT_TRUE(says(message([](Pair& p) {
                     const Anchor wall = p.builder.add_world_point({0, 0, 0});
                     p.builder.add(AlongRow{{{p.a, p.b, 1.0}, 0.0, wall}});
                   }),
                   "a dial of its own"));
  EXPECT_TRUE(says(message([](Pair& p) {
                     const Anchor dial = p.builder.add_dial(steady_target(0.0, 1.0));
                     p.builder.add(AlongRow{{{p.a, p.b, 1.0}, 0.0, dial}});
                     p.builder.add(AlongRow{{{p.a, p.b, 1.0}, 0.0, dial}});
                   }),
                   "used by one row"));
  EXPECT_TRUE(says(message([](Pair& p) {
                     p.builder.add(TurnRow{{{p.a, p.b, 1.0}}, Vector3d::UnitZ(), Vector3d::UnitZ()});
                   }),
                   "perpendicular"));
  EXPECT_TRUE(says(message([](Pair& p) {
                     add_slide(p.builder, p.a, p.b, p.place, p.axis, {1.0},
                               Target{[](double t) { return 1.0 / t; }, [](double) { return 0.0; },
                                      [](double) { return 0.0; }});
                   }),
                   "finite"));
}

}  // namespace
}  // namespace feder
