// Bridges and nets of plates: what is joined to what, closed and at rest at the start.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engine/kkt.h"
#include "models/catalog.h"

namespace feder {
namespace {

double widest_gap(const Model& model) {
  VectorXd phi;
  evaluate_phi(model.system, model.state.q, phi);
  return phi.cwiseAbs().maxCoeff();
}

Vector3d point(const Model& model, int body, const Vector3d& at) {
  return position(model.system, {.body = body, .point = at}, model.state.q);
}

// Slope of the plate's long edge against +x [rad].
double slope(const Model& model, int body) {
  const Vector3d along =
      orientation(model.system.bodies[static_cast<std::size_t>(body)], model.state.q).col(0);
  return std::atan2(along.y(), along.x());
}

TEST(PlateBridge, HasItsPlatesAndJoints) {
  const struct {
    const char* spec;
    int bodies, joints;
  } cases[] = {{"S3b(30,10)", 300, 31 * 10 + 30 * 9}, {"S3b(2,1)", 2, 3}, {"S3b(4,3)", 12, 5 * 3 + 4 * 2}};
  for (const auto& c : cases) {
    const Model model = make_model(c.spec);
    EXPECT_EQ(std::ssize(model.system.bodies), c.bodies) << c.spec;
    EXPECT_EQ(model.system.active_rows, 3 * c.joints) << c.spec;
    EXPECT_EQ(model.system.free_count, 6 * c.bodies) << c.spec;
    EXPECT_NEAR(model.system.mass.sum(), 0.4 * c.bodies, 1e-12) << c.spec;
  }
}

TEST(PlateBridge, IsClosedAtTheStart) {
  for (const char* spec : {"S3b(30,10)", "S3b(40,30)", "S3b(2,1)", "S3b(3,2)", "S3b(5,2)"})
    EXPECT_LT(widest_gap(make_model(spec)), 1e-14) << spec;  // 1.8e-15
}

TEST(PlateBridge, ReturnsToTheStartHeight) {
  for (int nx : {2, 3, 4, 5, 30, 31, 32}) {
    const Model model = make_model("plate_bridge:ny=2,nx=" + std::to_string(nx));
    for (int row : {0, 1}) {
      const Vector3d first = point(model, row * nx, {-0.1, 0.0, 0.0});
      const Vector3d last = point(model, (row + 1) * nx - 1, {0.1, 0.0, 0.0});
      EXPECT_NEAR((first - Vector3d(0.0, 0.0, 0.2 * row + 0.1)).norm(), 0.0, 1e-15) << nx;
      EXPECT_NEAR(last.y(), 0.0, 1e-14) << nx;
      EXPECT_GT(last.x(), 0.1 * nx) << nx;
    }
  }
}

TEST(PlateBridge, GoesDownAThirdAndStraightBackUp) {
  const Model model = make_model("S3b(30,1)");
  const double up = std::asin(10.0 * std::sin(std::numbers::pi / 3.0) / 20.0);
  for (int i = 0; i < 10; ++i) EXPECT_NEAR(slope(model, i), -std::numbers::pi / 3.0, 1e-14) << i;
  for (int i = 10; i < 30; ++i) EXPECT_NEAR(slope(model, i), up, 1e-14) << i;
  const Vector3d lowest = point(model, 10, {-0.1, 0.0, 0.0});
  EXPECT_NEAR(lowest.y(), -2.0 * std::sin(std::numbers::pi / 3.0), 1e-14);
}

TEST(PlateBridge, IsHardUnlessToldOtherwise) {
  const Model hard = make_model("S3b(6,2)"), soft = make_model("S3b(6,2):stiffness=1e5,damping_time=1e-3");
  EXPECT_TRUE(hard.system.has_hard_rows);
  EXPECT_FALSE(soft.system.has_hard_rows);
  EXPECT_DOUBLE_EQ(soft.system.stiffness.maxCoeff(), 1e5);
  EXPECT_EQ(hard.conserved.size(), 1u);
  EXPECT_TRUE(soft.conserved.empty());
  EXPECT_DOUBLE_EQ(hard.scene_length, 1.2);
  EXPECT_EQ(hard.end_time, 0.25);
  EXPECT_EQ(hard.state.v.norm(), 0.0);
}

TEST(PlateNet, HasItsPlatesAndJoints) {
  for (int n : {1, 2, 7}) {
    const Model model = make_model("plate_net:n=" + std::to_string(n));
    EXPECT_EQ(std::ssize(model.system.bodies), n * n);
    EXPECT_EQ(model.system.active_rows, 3 * (n * n + n * (n - 1)));
    EXPECT_FALSE(model.system.has_hard_rows);
    EXPECT_LT(widest_gap(model), 1e-14);  // 1.1e-16
    EXPECT_DOUBLE_EQ(model.scene_length, 0.1 * n);
  }
}

TEST(PlateNet, IsHeldAlongOneEdge) {
  const Model model = make_model("plate_net:n=3");
  EXPECT_EQ(model.system.nodes, 9 + 9 + 3);
  for (int j = 0; j < 3; ++j) {
    EXPECT_NEAR(point(model, 3 * j, {-0.05, 0.0, 0.0}).x(), 0.0, 1e-16);
    EXPECT_NEAR((point(model, 3 * j + 2, {0.05, 0.0, 0.0}) - Vector3d(0.3, 0.0, 0.1 * j + 0.05)).norm(), 0.0,
                1e-15);
  }
}

TEST(PlateNet, FallsFreelyAtFirst) {
  const Model model = make_model("plate_net:n=4");
  VectorXd f;
  ASSERT_TRUE(evaluate_forces(model.system, model.state, f).ok());
  EXPECT_EQ(model.state.v.norm(), 0.0);
  for (const Body& body : model.system.bodies) {
    const Vector3d rate =
        f.segment<3>(3 * body.centre).cwiseProduct(model.system.inverse_mass.segment<3>(3 * body.centre));
    EXPECT_NEAR((rate - Vector3d(0.0, -9.81, 0.0)).norm(), 0.0, 1e-8);  // springs of 1e6 N/m open by 1e-16 m
  }
}

}  // namespace
}  // namespace feder
