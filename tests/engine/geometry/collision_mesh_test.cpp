#include "engine/geometry/collision_mesh.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/check.h"
#include "engine/geometry/aabb.h"
#include "tests/engine/geometry/random_mesh.h"
#include "tests/support/campaign.h"

namespace feder {
namespace {

constexpr double kPi = std::numbers::pi;

TriangleMesh tetrahedron() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
}

// Vertices on the torus of circle radius 1 and tube radius 0.4, axis z.
TriangleMesh torus(int around, int across) {
  TriangleMesh mesh;
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double u = 2.0 * kPi * i / around, v = 2.0 * kPi * j / across, r = 1.0 + 0.4 * std::cos(v);
      mesh.vertices.emplace_back(r * std::cos(u), r * std::sin(u), 0.4 * std::sin(v));
      const int right = (i + 1) % around * across, here = i * across, up = (j + 1) % across;
      mesh.triangles.push_back({here + j, right + j, right + up});
      mesh.triangles.push_back({here + j, right + up, here + up});
    }
  return mesh;
}
double torus_distance(const Vector3d& p) {
  return std::hypot(std::hypot(p.x(), p.y()) - 1.0, p.z()) - 0.4;
}

// A star: the unit tetrahedron with a long spike on every face; sharp edges and corners, reentrant ones too.
TriangleMesh star(Random& random) {
  TriangleMesh mesh{tetrahedron().vertices, {}};
  for (const auto& [i, j, k] : tetrahedron().triangles) {
    const Vector3d a = mesh.vertices[i], b = mesh.vertices[j], c = mesh.vertices[k];
    const int tip = static_cast<int>(mesh.vertices.size());
    mesh.vertices.push_back((a + b + c) / 3.0 + random.uniform(0.2, 2.0) * (b - a).cross(c - a));
    mesh.triangles.insert(mesh.triangles.end(), {{i, j, tip}, {j, k, tip}, {k, i, tip}});
  }
  return mesh;
}

// Winding number: the solid angle of the surface over 4 pi (van Oosterom and Strackee 1983).
double winding_number(const TriangleMesh& mesh, const Vector3d& p) {
  double angle = 0.0;
  for (const auto& [i, j, k] : mesh.triangles) {
    const Vector3d a = mesh.vertices[i] - p, b = mesh.vertices[j] - p, c = mesh.vertices[k] - p;
    const double u = a.norm(), v = b.norm(), w = c.norm();
    angle += std::atan2(a.dot(b.cross(c)), u * v * w + a.dot(b) * w + b.dot(c) * u + c.dot(a) * v);
  }
  return angle / (2.0 * kPi);
}

// Full campaign: 300 stars, 1000 points each.
TEST(CollisionMeshCampaign, SignIsThatOfTheWindingNumber) {
  int corners = 0, inside = 0;
  for (int seed = 0; seed < test::campaign_cases(300); ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    const TriangleMesh mesh = star(random);
    const CollisionMesh solid("star", mesh);
    for (int k = 0; k < 1000; ++k) {
      const Vector3d p = random.vector(1.5);
      const auto nearest = solid.closest_point(p, 10.0);
      ASSERT_TRUE(nearest);
      if (std::abs(nearest->signed_distance) < 1e-9) continue;
      ASSERT_EQ(nearest->signed_distance<0.0, winding_number(mesh, p)> 0.5)
          << "seed " << seed << ", point " << k;
      ASSERT_NEAR((p - nearest->point).norm(), std::abs(nearest->signed_distance), 1e-15);
      corners += nearest->feature == Feature::kVertex;
      inside += nearest->signed_distance < 0.0;
    }
  }
  EXPECT_GT(corners, 10);
  EXPECT_GT(inside, 100);
}

// Chords lie within 0.4 (1 - cos(pi/100)) + 1.4 (1 - cos(pi/200)) = 3.7e-4 of the torus; measured 3.1e-4.
TEST(CollisionMesh, SignedDistanceOfATorusIsTheAnalyticOne) {
  const CollisionMesh solid("torus", torus(200, 100));
  Random random(1);
  double worst = 0.0;
  for (int k = 0; k < 2000; ++k) {
    const Vector3d p = random.vector(1.6);
    worst = std::max(worst, std::abs(solid.closest_point(p, 10.0)->signed_distance - torus_distance(p)));
  }
  EXPECT_LT(worst, 3.7e-4);
}

// A wedge whose bottom meets the origin in 20 thin triangles: by the plain mean of the face normals there,
// points behind its edge count as inside.
TEST(CollisionMesh, WeighsNormalsByAnglesUnlikeTheirMean) {
  TriangleMesh mesh{{{0, 0, 0}, {0.2, 0.2, 1}}, {}};
  const int parts = 20;
  for (int k = 0; k <= parts; ++k) mesh.vertices.emplace_back(1.0 - 1.0 * k / parts, 1.0 * k / parts, 0.0);
  for (int k = 0; k < parts; ++k) {
    mesh.triangles.push_back({0, k + 3, k + 2});
    mesh.triangles.push_back({1, k + 2, k + 3});
  }
  mesh.triangles.push_back({0, 2, 1});
  mesh.triangles.push_back({0, 1, parts + 2});
  const CollisionMesh solid("wedge", mesh);
  Vector3d mean = Vector3d::Zero();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int vertex : mesh.triangles[t])
      if (vertex == 0) mean += solid.face_normals()[t];
  Random random(3);
  int wrong = 0;
  for (int k = 0; k < 10000; ++k) {
    const Vector3d p = random.vector(0.1);
    const auto nearest = solid.closest_point(p, 1.0);
    if (nearest->feature != Feature::kVertex) continue;
    EXPECT_GT(nearest->signed_distance, 0.0);
    wrong += mean.dot(p - nearest->point) < 0.0;
  }
  EXPECT_GT(wrong, 100);
}

// Feature and index name what the point is on; normals there are unit and outward.
TEST(CollisionMesh, NamesTheFeatureUnderThePoint) {
  const CollisionMesh solid("tetrahedron", tetrahedron());
  EXPECT_EQ(solid.edges().size(), 6u);
  const auto face = solid.closest_point({0.2, 0.3, -1.0}, 5.0),
             edge = solid.closest_point({0.3, -1.0, -1.0}, 5.0),
             corner = solid.closest_point({-1.0, -2.0, -3.0}, 5.0);
  EXPECT_EQ(face->feature, Feature::kFace);
  EXPECT_EQ(face->index, 0);
  EXPECT_EQ(face->normal, Vector3d(0, 0, -1));
  EXPECT_EQ(edge->feature, Feature::kEdge);
  EXPECT_EQ(solid.edges()[edge->index].a, 0);
  EXPECT_EQ(solid.edges()[edge->index].b, 1);
  EXPECT_NEAR((edge->normal - Vector3d(0, -1, -1).normalized()).norm(), 0.0, 1e-15);
  EXPECT_EQ(corner->feature, Feature::kVertex);
  EXPECT_EQ(corner->index, 0);
  EXPECT_NEAR((corner->normal + Vector3d::Ones().normalized()).norm(), 0.0, 1e-15);
}

TEST(CollisionMesh, AnswersWithinTheMarginOnly) {
  const CollisionMesh solid("tetrahedron", tetrahedron());
  EXPECT_TRUE(solid.closest_point({-1, 0, 0}, 1.0));
  EXPECT_FALSE(solid.closest_point({-1, 0, 0}, std::nextafter(1.0, 0.0)));
}

TEST(CollisionMesh, VisitsTheTrianglesWhoseBoxesMeetABox) {
  const TriangleMesh mesh = torus(60, 30);
  const CollisionMesh solid("torus", mesh);
  Random random(2);
  for (int k = 0; k < 200; ++k) {
    const Vector3d centre = random.vector(1.4), half = random.vector(0.3).cwiseAbs();
    const Aabb box{centre - half, centre + half};
    std::vector<int> expected, found;
    for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t)
      if (overlap(box, fit_aabb(test::corners_of(mesh, t)))) expected.push_back(t);
    solid.visit_triangles(box, [&](int t) { found.push_back(t); });
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected);
  }
}

TEST(CollisionMesh, RefusesOpenMeshesAndTrianglesWithoutArea) {
  TriangleMesh open = tetrahedron(), flat = tetrahedron();
  open.triangles.pop_back();
  EXPECT_THROW(CollisionMesh("scene", open), InputError);
  EXPECT_THROW(CollisionMesh("scene", TriangleMesh{}), InputError);
  TriangleMesh inside_out = tetrahedron();
  for (auto& triangle : inside_out.triangles) std::swap(triangle[0], triangle[1]);
  EXPECT_THROW(CollisionMesh("scene", inside_out), InputError);
  // the corner between 1 and 2 of a triangle cut in two, one half without area
  flat.vertices.push_back({0.5, 0.5, 0});
  flat.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 4, 3}, {4, 2, 3}, {1, 2, 4}, {0, 3, 2}};
  EXPECT_THROW(CollisionMesh("scene", flat), InputError);
}

}  // namespace
}  // namespace feder
