// Arms by their tables: the formulas of the notes F1, F3, F5 and F7 to F9 with their slips as twins, and
// poses that are known.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "engine/check.h"
#include "models/robot/arms.h"
#include "tests/support/finite_difference.h"
#include "tests/support/random.h"

namespace feder {
namespace {

using Eigen::Matrix4d;
constexpr double kPi = std::numbers::pi, kRight = 0.5 * kPi;

double distance(const Pose& a, const Pose& b) {
  return (homogeneous(a) - homogeneous(b)).norm();
}

VectorXd random_joints(Random& random, const Arm& arm) {
  VectorXd q(arm.joints());
  for (int i = 0; i < arm.joints(); ++i) q[i] = random.uniform(arm.rows[i].least, arm.rows[i].greatest);
  return q;
}

DhRow random_row(Random& random) {
  return {.a = random.uniform(),
          .alpha = random.uniform(-3.0, 3.0),
          .d = random.uniform(),
          .theta = random.uniform(-3.0, 3.0)};
}

Matrix4d rotation(const Vector3d& axis, double angle) {
  Matrix4d T = Matrix4d::Identity();
  T.topLeftCorner<3, 3>() = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  return T;
}
Matrix4d translation(const Vector3d& axis, double way) {
  Matrix4d T = Matrix4d::Identity();
  T.topRightCorner<3, 1>() = way * axis;
  return T;
}
const Vector3d kX = Vector3d::UnitX(), kZ = Vector3d::UnitZ();

class EveryArm : public testing::TestWithParam<std::string> {
 protected:
  const Arm arm = make_arm(GetParam());
};
std::vector<std::string> names() {
  std::vector<std::string> list;
  for (const ArmInfo& info : arm_list()) list.push_back(info.name);
  return list;
}
INSTANTIATE_TEST_SUITE_P(Arms, EveryArm, testing::ValuesIn(names()), [](const auto& i) { return i.param; });

// ---- F8, F9: one row

TEST(DhRow, IsTheProductOfFourMotions) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const DhRow row = random_row(random);
    const double q = random.uniform();
    const Matrix4d product = rotation(kZ, row.theta + q) * translation(kZ, row.d) * translation(kX, row.a) *
                             rotation(kX, row.alpha);
    const Matrix4d T = homogeneous(row_transform(row, DhConvention::kStandard, q));
    EXPECT_LT((T - product).norm(), 2e-15);  // 7e-16
    // slip 8: the notes print a translation by the twist
    const Matrix4d printed = rotation(kZ, row.theta + q) * translation(kZ, row.d) * translation(kX, row.a) *
                             translation(kX, row.alpha);
    EXPECT_GT((T - printed).norm(), 1e-2 * std::abs(row.alpha));
  }
}

TEST(DhRow, IsTheMatrixOfTheNotes) {
  const DhRow row{.a = 0.3, .alpha = 0.7, .d = -0.2, .theta = 0.4};
  const double ct = std::cos(1.5), st = std::sin(1.5), ca = std::cos(0.7), sa = std::sin(0.7);
  Matrix4d F9;
  F9 << ct, -st * ca, st * sa, 0.3 * ct, st, ct * ca, -ct * sa, 0.3 * st, 0.0, sa, ca, -0.2, 0.0, 0.0, 0.0,
      1.0;
  EXPECT_LT((homogeneous(row_transform(row, DhConvention::kStandard, 1.1)) - F9).norm(), 1e-15);
}

TEST(DhRow, OtherOrderIsAnotherTransform) {
  const DhRow row{.a = 0.3, .alpha = 0.7, .d = -0.2, .theta = 0.4};
  const Matrix4d craig = rotation(kX, 0.7) * translation(kX, 0.3) * rotation(kZ, 0.4) * translation(kZ, -0.2);
  const Pose modified = row_transform(row, DhConvention::kModified, 0.0);
  EXPECT_LT((homogeneous(modified) - craig).norm(), 1e-15);
  EXPECT_GT(distance(modified, row_transform(row, DhConvention::kStandard, 0.0)), 0.1);  // 0.68
}

// F7: the twist is the angle between the z axes about x; the notes measure it between the y axes.
TEST(DhRow, TwistIsTheAngleBetweenTheJointAxes) {
  Random random(2);
  int between_y = 0;
  for (int i = 0; i < 100; ++i) {
    const DhRow row = random_row(random);
    const Matrix3d R = row_transform(row, DhConvention::kStandard, 0.0).rotation;
    EXPECT_NEAR(std::atan2(R.col(0).dot(kZ.cross(R.col(2))), kZ.dot(R.col(2))), row.alpha, 1e-14);
    const double y = std::acos(std::clamp(R(1, 1), -1.0, 1.0));
    between_y += std::abs(y - std::abs(row.alpha)) < 1e-3;
  }
  EXPECT_LT(between_y, 5);
}

TEST(DhRow, PrismaticJointSlidesAlongZ) {
  const DhRow row{.a = 0.3, .alpha = 0.7, .d = 0.1, .theta = 0.4, .prismatic = true};
  DhRow longer = row;
  longer.d = 0.6, longer.prismatic = false;
  EXPECT_EQ(distance(row_transform(row, DhConvention::kStandard, 0.5),
                     row_transform(longer, DhConvention::kStandard, 0.0)),
            0.0);
}

TEST(Frames, TransformTimesInverseIsTheIdentity) {
  Random random(3);
  for (int i = 0; i < 100; ++i) {
    const Pose T = row_transform(random_row(random), DhConvention::kStandard, 0.0);
    EXPECT_LT(distance(product(T, inverse(T)), Pose{}), 2e-15);
    EXPECT_LT((homogeneous(inverse(T)) - homogeneous(T).inverse()).norm(), 1e-14);
  }
}

// F8: T takes coordinates of a point from B to A, and moves frame A onto frame B.
TEST(Frames, BothReadingsOfATransformAgree) {
  const Pose A{Eigen::AngleAxisd(0.3, Vector3d(1.0, 2.0, 2.0) / 3.0).toRotationMatrix(), {0.1, 0.2, 0.3}};
  const Pose T =
      row_transform({.a = 0.3, .alpha = 0.7, .d = -0.2, .theta = 0.4}, DhConvention::kStandard, 0.0);
  const Vector3d in_B(0.5, -0.4, 0.9);
  const Vector3d in_A = T.rotation * in_B + T.position, in_world = A.rotation * in_A + A.position;
  // the frame moved: origin by T's translation along A's own axes, axes turned about A's own axes
  const Vector3d origin = A.position + A.rotation * T.position;
  const Matrix3d axes = A.rotation * T.rotation;
  EXPECT_LT((origin + axes * in_B - in_world).norm(), 1e-15);
  // the other way round they are not the same
  EXPECT_GT(distance(product(A, T), product(T, A)), 0.1);
}

// ---- F1, F3: chains

TEST(Planar2R, IsTheFormulaOfTheNotes) {
  const double a = 0.8, b = 0.5;
  Random random(4);
  for (int i = 0; i < 100; ++i) {
    const double A = random.uniform(-kPi, kPi), B = random.uniform(-kPi, kPi);
    const std::vector<Pose> all = frames(planar_2r(a, b), VectorXd{{A, B}});
    const Vector3d elbow(a * std::cos(A), a * std::sin(A), 0.0);
    const Vector3d hand = elbow + Vector3d(b * std::cos(A + B), b * std::sin(A + B), 0.0);
    EXPECT_LT((all[1].position - elbow).norm(), 1e-15);
    EXPECT_LT((all.back().position - hand).norm(), 1e-15);
  }
}

TEST(Planar2R, StandsOnTheUnitCircleWhereItShould) {
  const Arm arm = planar_2r(1.0, 1.0);
  auto hand = [&](double A, double B) { return tool_pose(arm, VectorXd{{A, B}}).position; };
  EXPECT_LT((hand(0.0, 0.0) - Vector3d(2.0, 0.0, 0.0)).norm(), 1e-15);
  EXPECT_LT((hand(kRight, 0.0) - Vector3d(0.0, 2.0, 0.0)).norm(), 1e-15);
  EXPECT_LT((hand(0.0, kRight) - Vector3d(1.0, 1.0, 0.0)).norm(), 1e-15);
  EXPECT_LT(hand(0.7, kPi).norm(), 1e-15);
}

TEST_P(EveryArm, JacobianIsTheDerivativeOfTheToolPose) {
  Random random(5);
  for (int i = 0; i < 20; ++i) {
    const VectorXd q = random_joints(random, arm);
    const Pose at = tool_pose(arm, q);
    const Eigen::MatrixXd numeric = finite_jacobian(
        [&](const VectorXd& p) -> VectorXd {
          const Pose tool = tool_pose(arm, p);
          const Eigen::AngleAxisd turn(tool.rotation * at.rotation.transpose());
          VectorXd out(6);
          out << tool.position, turn.angle() * turn.axis();
          return out;
        },
        q, 1e-3);
    const ToolJacobian J = tool_jacobian(arm, q);
    ASSERT_GT(J.norm(), 0.1);
    EXPECT_LT((J - numeric).norm(), 1e-10);  // 2e-12
  }
}

TEST_P(EveryArm, MapSeesThePoseOfTheChain) {
  Random random(6);
  const KinematicMap map = kinematic_map(arm);
  for (int i = 0; i < 20; ++i) {
    const VectorXd q = random_joints(random, arm);
    Pose tool;
    ToolJacobian J;
    map.evaluate(q.data(), tool, J);
    EXPECT_LT(distance(tool, tool_pose(arm, q)), 1e-14);
    EXPECT_EQ((J - tool_jacobian(arm, q)).norm(), 0.0);
  }
}

TEST_P(EveryArm, StandardAndModifiedTablesAgree) {
  Random random(7);
  const Arm modified = as_modified(arm);
  EXPECT_EQ(modified.convention, DhConvention::kModified);
  Arm misread = arm;
  misread.convention = DhConvention::kModified;
  double apart = 0.0;
  for (int i = 0; i < 20; ++i) {
    const VectorXd q = random_joints(random, arm);
    EXPECT_LT(distance(tool_pose(arm, q), tool_pose(modified, q)), 1e-14);
    EXPECT_LT((tool_jacobian(arm, q) - tool_jacobian(modified, q)).norm(), 1e-14);
    apart = std::max(apart, distance(tool_pose(arm, q), tool_pose(misread, q)));
  }
  // the same numbers under the other convention are another arm
  if (arm.convention == DhConvention::kStandard) EXPECT_GT(apart, 0.1);
}

// F5 for any chain: no joints lead out of the ring.
TEST_P(EveryArm, ReachContainsEveryPlaceOfTheTool) {
  Random random(8);
  const Ring ring = reach_of(arm);
  double nearest = 1e9, farthest = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const double r = (tool_pose(arm, random_joints(random, arm)).position - ring.centre).norm();
    nearest = std::min(nearest, r), farthest = std::max(farthest, r);
  }
  EXPECT_GE(nearest, ring.least - 1e-12);
  EXPECT_LE(farthest, ring.greatest + 1e-12);
  EXPECT_GT(farthest, 0.8 * ring.greatest);  // a bound that says something
}

TEST(Planar2R, SampledReachIsTheRing) {
  for (const auto& [a, b] : {std::pair{0.8, 0.5}, std::pair{0.5, 0.8}, std::pair{0.6, 0.6}}) {
    const Arm arm = planar_2r(a, b);
    const Ring ring = reach_of(arm);
    EXPECT_NEAR(ring.greatest, a + b, 1e-15);
    EXPECT_NEAR(ring.least, std::abs(a - b), 1e-15);
    double nearest = 1e9, farthest = 0.0;
    for (int i = 0; i <= 1000; ++i) {
      const double r = tool_pose(arm, VectorXd{{0.3, -kPi + 2.0 * kPi * i / 1000}}).position.norm();
      nearest = std::min(nearest, r), farthest = std::max(farthest, r);
    }
    EXPECT_NEAR(nearest, std::abs(a - b), 1e-12);
    EXPECT_NEAR(farthest, a + b, 1e-12);
  }
}

// A planar arm with a step in z between its links reaches the same ring of the plane.
TEST(Reach, OfAFlatTaskDoesNotSeeOffsetsAlongZ) {
  Arm arm = planar_2r(0.8, 0.5);
  arm.rows[1].d = 0.7;
  EXPECT_NEAR(reach_of(arm).greatest, 1.3, 1e-15);
  EXPECT_NEAR(reach_of(arm).least, 0.3, 1e-15);
  arm.task = {0, 1, 2};
  EXPECT_NEAR(reach_of(arm).greatest, std::hypot(0.5, 0.0) + std::hypot(0.8, 0.7), 1e-15);
  arm.task = {0};
  EXPECT_EQ(reach_of(arm).least, 0.0);
}

// ---- The catalogue: poses that are known

void expect_pose(const Arm& arm, const VectorXd& q, const Matrix3d& R, const Vector3d& p, double bound) {
  const Pose tool = tool_pose(arm, q);
  EXPECT_LT((tool.position - p).norm(), bound) << tool.position.transpose();
  EXPECT_LT((tool.rotation - R).norm(), bound) << tool.rotation;
}

TEST(Ur5, AtZeroIsTheProductOfItsTable) {
  // x = a2 + a3, y = -d4 - d6, z = d1 - d5; the tool's z along -y
  Matrix3d R;
  R << 1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0;
  expect_pose(ur5(), VectorXd::Zero(6), R, {-0.425 - 0.39225, -0.10915 - 0.0823, 0.089159 - 0.09465}, 1e-15);
  // and row by row as matrices
  Random random(9);
  const Arm arm = ur5();
  const VectorXd q = random_joints(random, arm);
  Matrix4d T = Matrix4d::Identity();
  for (int i = 0; i < 6; ++i)
    T = T * rotation(kZ, q[i]) * translation(kZ, arm.rows[i].d) * translation(kX, arm.rows[i].a) *
        rotation(kX, arm.rows[i].alpha);
  EXPECT_LT((homogeneous(tool_pose(arm, q)) - T).norm(), 1e-14);
}

// Poses qz and qn of the Robotics Toolbox; qn as printed there, to four digits.
TEST(Puma560, StandsAsPublished) {
  expect_pose(puma560(), VectorXd::Zero(6), Matrix3d::Identity(), {0.4318 + 0.0203, -0.15005, 0.4318}, 1e-15);
  Matrix3d R;
  R << 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0;
  expect_pose(puma560(), VectorXd{{0.0, 0.25 * kPi, kPi, 0.0, 0.25 * kPi, 0.0}}, R,
              {0.5963, -0.1501, -0.01435}, 1e-4);
}

TEST(Panda, StandsAsItsTableSays) {
  const Matrix3d down = Vector3d(1.0, -1.0, -1.0).asDiagonal();
  expect_pose(panda(), VectorXd::Zero(7), down, {0.088, 0.0, 0.333 + 0.316 + 0.384 - 0.107}, 1e-15);
}

TEST(Stanford, AtZeroTurnsReachesAlongItsRack) {
  // d1 up, d2 across, then rack and wrist along z of the third joint
  VectorXd q = VectorXd::Zero(6);
  q[2] = 0.5;
  EXPECT_LT((tool_pose(stanford(), q).position - Vector3d(0.0, 0.154, 0.412 + 0.5 + 0.263)).norm(), 1e-15);
}

// ---- Bad tables

std::string message_of(const Arm& arm) {
  try {
    (void)kinematic_map(arm);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Table, IsCheckedRowByRow) {
  Arm arm = ur5();
  EXPECT_EQ(message_of(arm), "accepted");
  arm.rows[2].alpha = std::nan("");
  EXPECT_NE(message_of(arm).find("arm 'ur5' row 3: alpha = nan rad"), std::string::npos) << message_of(arm);
  arm = stanford();
  arm.rows[2].least = 2.0;
  EXPECT_NE(message_of(arm).find("arm 'stanford' row 3: least = 2 m, expected less than"), std::string::npos)
      << message_of(arm);
  arm.rows.clear();
  EXPECT_NE(message_of(arm).find("joints = 0"), std::string::npos);
  arm = panda();
  arm.task = {0, 6};
  EXPECT_NE(message_of(arm).find("task = 6"), std::string::npos);
  // out of order the turns would be left out without a word
  arm.task = {3, 0};
  EXPECT_NE(message_of(arm).find("task = 0, expected rows in ascending order"), std::string::npos);
  arm.task = {1, 1};
  EXPECT_NE(message_of(arm).find("task = 1, expected rows in ascending order"), std::string::npos);
  arm.task.clear();
  EXPECT_NE(message_of(arm).find("rows of the task = 0"), std::string::npos) << message_of(arm);
}

TEST(Table, IsCheckedForItsTool) {
  Arm arm = panda();
  arm.tool.position.x() = std::nan("");
  EXPECT_NE(message_of(arm).find("arm 'panda': tool position = nan m"), std::string::npos) << message_of(arm);
  arm = panda();
  arm.tool.rotation *= 1.001;
  EXPECT_NE(message_of(arm).find("|R R^T - E| of the tool = 0.003"), std::string::npos) << message_of(arm);
  arm.tool.rotation = Vector3d(1.0, 1.0, -1.0).asDiagonal();
  EXPECT_NE(message_of(arm).find("det R of the tool = -1"), std::string::npos) << message_of(arm);
}

TEST(Table, NamesTheArmsThereAre) {
  try {
    (void)make_arm("puma");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("planar_2r, planar_nr, puma560"), std::string::npos);
  }
}

}  // namespace
}  // namespace feder
