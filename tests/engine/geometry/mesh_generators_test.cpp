// Generated meshes: closed, of the right genus, on the true surface, and converging with order 2.
#include "engine/geometry/mesh_generators.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "engine/geometry/mesh_check.h"
#include "engine/mass_properties.h"
#include "tests/support/refused.h"

namespace feder {
namespace {

using std::numbers::pi;
using test::refused;

struct Generated {
  const char* name;
  int euler;
  double volume;                          // of the true solid [m^3]
  std::function<TriangleMesh(int)> make;  // n segments of a quarter circle
};

std::vector<Generated> all_shapes() {
  const double r = 0.7, h = 1.9, R = 1.6;
  return {{"box", 2, 3.0 * 2.0 * 0.5,
           [](int) {
             return box_mesh("box", {3.0, 2.0, 0.5});
           }},
          {"sphere", 2, 4.0 / 3.0 * pi * r * r * r, [=](int n) { return sphere_mesh("sphere", r, n); }},
          {"cylinder", 2, pi * r * r * h, [=](int n) { return cylinder_mesh("cylinder", r, h, n); }},
          {"capsule", 2, pi * r * r * (2.0 * h + 4.0 / 3.0 * r),
           [=](int n) { return capsule_mesh("capsule", r, h, n); }},
          {"torus", 0, 2.0 * pi * pi * R * r * r,
           [=](int n) { return torus_mesh("torus", R, r, 8 * n, 4 * n); }}};
}

double volume_of(const TriangleMesh& mesh) {
  return solid_mesh("mesh", 1.0, mesh).mass;
}

int edges_of(const TriangleMesh& mesh) {
  std::set<std::pair<int, int>> edges;
  for (const std::array<int, 3>& t : mesh.triangles)
    for (int i = 0; i < 3; ++i) edges.insert(std::minmax(t[i], t[(i + 1) % 3]));
  return static_cast<int>(edges.size());
}

// Of all triangles, from 1 for an equilateral one to 0 for a needle: 4 sqrt(3) area / sum of squared edges.
double worst_shape(const TriangleMesh& mesh) {
  double worst = 1.0;
  for (const auto& [i, j, k] : mesh.triangles) {
    const Vector3d a = mesh.vertices[j] - mesh.vertices[i], b = mesh.vertices[k] - mesh.vertices[i];
    const double sum = a.squaredNorm() + b.squaredNorm() + (a - b).squaredNorm();
    worst = std::min(worst, 2.0 * std::sqrt(3.0) * a.cross(b).norm() / sum);
  }
  return worst;
}

TEST(MeshGenerators, AreClosedWithTheRightEulerCharacteristic) {
  for (const Generated& shape : all_shapes())
    for (int n : {1, 2, 3, 7, 20}) {
      SCOPED_TRACE(shape.name + std::to_string(n));
      const TriangleMesh mesh = shape.make(n);
      EXPECT_NO_THROW(check_closed_mesh("mesh", mesh));
      EXPECT_EQ(static_cast<int>(mesh.vertices.size() + mesh.triangles.size()) - edges_of(mesh), shape.euler);
    }
}

TEST(MeshGenerators, HaveTheStatedNumberOfTriangles) {
  for (int n : {1, 2, 9}) {
    EXPECT_EQ(sphere_mesh("sphere", 1.0, n).triangles.size(), 8u * n * n);
    EXPECT_EQ(cylinder_mesh("cylinder", 1.0, 1.0, n).triangles.size(), 8u * n * n + 8u * n);
    EXPECT_EQ(capsule_mesh("capsule", 1.0, 1.0, n).triangles.size(), 8u * n * n + 8u * n);
    EXPECT_EQ(torus_mesh("torus", 2.0, 1.0, 3 * n, 5 * n).triangles.size(), 30u * n * n);
  }
}

TEST(MeshGenerators, VolumeConvergesWithOrderTwoToTheClosedForm) {
  for (const Generated& shape : all_shapes()) {
    SCOPED_TRACE(shape.name);
    double error[2];
    for (int finer : {0, 1}) error[finer] = std::abs(volume_of(shape.make(16 << finer)) / shape.volume - 1.0);
    if (shape.name == std::string("box")) {
      EXPECT_LT(error[1], 1e-15);  // 0
      continue;
    }
    const double order = std::log2(error[0] / error[1]);
    ASSERT_GT(error[1], 1e-4);  // at least 4e-4
    EXPECT_GT(order, 1.98);     // 1.994 to 1.9995
    EXPECT_LT(order, 2.02);
  }
}

TEST(MeshGenerators, InertiaOfAnEllipsoidConvergesWithOrderTwo) {
  const Vector3d s(1.0, 2.0, 0.5);  // half axes
  const double mass = 4.0 / 3.0 * pi * s.prod();
  const Matrix3d exact = inertia_from_covariance(Vector3d(mass / 5.0 * s.cwiseAbs2()).asDiagonal());
  double error[2];
  for (int finer : {0, 1}) {
    TriangleMesh mesh = sphere_mesh("ellipsoid", 1.0, 16 << finer);
    for (Vector3d& x : mesh.vertices) x = s.cwiseProduct(x);
    error[finer] = (solid_mesh("ellipsoid", 1.0, mesh).inertia - exact).norm() / exact.norm();
  }
  ASSERT_GT(error[1], 1e-4);                               // 2.3e-3
  EXPECT_NEAR(std::log2(error[0] / error[1]), 2.0, 0.02);  // 1.995
}

TEST(MeshGenerators, VerticesLieOnTheTrueSurface) {
  for (const Vector3d& x : sphere_mesh("sphere", 0.7, 9).vertices) EXPECT_NEAR(x.norm(), 0.7, 1e-15);
  for (const Vector3d& x : capsule_mesh("capsule", 0.7, 1.9, 9).vertices)
    EXPECT_NEAR((x - Vector3d(0, 0, std::clamp(x.z(), -1.9, 1.9))).norm(), 0.7, 1e-15);
  for (const Vector3d& x : torus_mesh("torus", 1.6, 0.7, 24, 12).vertices)
    EXPECT_NEAR(std::hypot(std::hypot(x.x(), x.y()) - 1.6, x.z()), 0.7, 1e-15);
}

TEST(MeshGenerators, ASphereHasNoNeedles) {
  for (int n : {1, 2, 8, 64}) EXPECT_GT(worst_shape(sphere_mesh("sphere", 1.0, n)), 0.6) << n;  // 0.81
}

TEST(MeshGenerators, RefuseWhatIsNotPositiveByName) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (double bad : {0.0, -1.0, nan, std::numeric_limits<double>::infinity()}) {
    EXPECT_TRUE(refused("s: edge length y = ", [&] { box_mesh("s", {1, bad, 1}); }));
    EXPECT_TRUE(refused("s: radius = ", [&] { sphere_mesh("s", bad, 3); }));
    EXPECT_TRUE(refused("s: radius = ", [&] { cylinder_mesh("s", bad, 1, 3); }));
    EXPECT_TRUE(refused("s: height = ", [&] { cylinder_mesh("s", 1, bad, 3); }));
    EXPECT_TRUE(refused("s: radius = ", [&] { capsule_mesh("s", bad, 1, 3); }));
    EXPECT_TRUE(refused("s: half length = ", [&] { capsule_mesh("s", 1, bad, 3); }));
    EXPECT_TRUE(refused("s: circle radius = ", [&] { torus_mesh("s", bad, 0.1, 9, 9); }));
    EXPECT_TRUE(refused("s: tube radius = ", [&] { torus_mesh("s", 1, bad, 9, 9); }));
  }
  EXPECT_TRUE(refused("s: tube radius = 1 m, expected less than", [] { torus_mesh("s", 1, 1, 9, 9); }));
}

TEST(MeshGenerators, RefuseTooFewAndTooManySegments) {
  for (int bad : {-1, 0, 9001, std::numeric_limits<int>::max()}) {
    const std::string text = "s: segments of a quarter circle = ";
    EXPECT_TRUE(refused(text, [&] { sphere_mesh("s", 1, bad); }));
    EXPECT_TRUE(refused(text, [&] { cylinder_mesh("s", 1, 1, bad); }));
    EXPECT_TRUE(refused(text, [&] { capsule_mesh("s", 1, 1, bad); }));
  }
  EXPECT_TRUE(refused("s: segments around = 2, expected from 3", [] { torus_mesh("s", 2, 1, 2, 9); }));
  EXPECT_TRUE(refused("s: segments across = 2, expected from 3", [] { torus_mesh("s", 2, 1, 9, 2); }));
  EXPECT_TRUE(refused("s: segments across = 100000, ", [] { torus_mesh("s", 2, 1, 100000, 100000); }));
}

}  // namespace
}  // namespace feder
