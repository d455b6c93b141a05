// Every way in which a mesh fails to enclose a solid has an error of its own that names the element.
#include "engine/geometry/mesh_check.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "engine/geometry/mesh_generators.h"
#include "tests/support/campaign.h"
#include "tests/support/random.h"
#include "tests/support/refused.h"

namespace feder {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
using Triangle = std::array<int, 3>;

testing::AssertionResult refused(const std::string& part, const TriangleMesh& mesh) {
  return test::refused(part, [&] { check_closed_mesh("mesh", mesh); });
}

TriangleMesh cube() {
  return box_mesh("cube", Vector3d::Ones());
}

void append(TriangleMesh& mesh, const TriangleMesh& other) {
  const int first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& [a, b, c] : other.triangles) mesh.triangles.push_back({first + a, first + b, first + c});
}

void rename(TriangleMesh& mesh, int from, int to) {
  for (Triangle& t : mesh.triangles) std::replace(t.begin(), t.end(), from, to);
}

TEST(MeshCheck, NamesTheVertexTwoCubesShare) {
  TriangleMesh mesh = cube(), other = cube();
  for (Vector3d& x : other.vertices) x += Vector3d::Ones();
  append(mesh, other);
  EXPECT_NO_THROW(check_closed_mesh("mesh", mesh));  // corners in one place are no shared vertex
  rename(mesh, 8, 7);
  EXPECT_TRUE(refused(
      "mesh, vertex 7 of triangles 11 and 17: number of fans = 2, expected 1: the mesh is not manifold",
      mesh));
}

TEST(MeshCheck, CountsTheFansOfAVertex) {
  TriangleMesh mesh = cube();
  for (int i = 1; i < 4; ++i) {
    append(mesh, cube());
    rename(mesh, 8 * i, 0);
  }
  EXPECT_TRUE(refused("mesh, vertex 0 of triangles", mesh));
  EXPECT_TRUE(refused("number of fans = 4", mesh));
}

TEST(MeshCheck, AcceptsAHandleAndACavity) {
  EXPECT_NO_THROW(check_closed_mesh("mesh", torus_mesh("torus", 2.0, 1.0, 9, 5)));
  TriangleMesh mesh = cube(), inner = cube();
  for (Vector3d& x : inner.vertices) x *= 0.5;
  for (Triangle& t : inner.triangles) std::swap(t[1], t[2]);
  append(mesh, inner);
  EXPECT_NO_THROW(check_closed_mesh("mesh", mesh));
}

// A mesh after one mutation, and what must be said about it: one of the classes, one of the elements.
struct Mutant {
  TriangleMesh mesh;
  std::vector<std::string> classes, elements;
};

const std::string kOpen = "the mesh is open here", kFan = "number of fans",
                  kManyTriangles = "2: the mesh is not manifold here",
                  kWinding = "the winding is inconsistent", kIndex = "vertex index", kPosition = "position",
                  kVolume = "volume = inf m^3", kFlat = "the mesh is flat",
                  kInsideOut = "the mesh is inside out", kEmpty = "expected a closed mesh";

std::vector<std::string> edges_of(const Triangle& t) {
  std::vector<std::string> out;
  for (int i = 0; i < 3; ++i) {
    const auto [low, high] = std::minmax(t[i], t[(i + 1) % 3]);
    out.push_back("edge (" + std::to_string(low) + ", " + std::to_string(high) + ")");
  }
  return out;
}

TriangleMesh random_solid(Random& random) {
  const int n = 1 + random.below(4);
  TriangleMesh mesh = [&] {
    switch (random.below(5)) {
      case 0:
        return box_mesh("box", Vector3d::Constant(1.5) + random.vector());
      case 1:
        return sphere_mesh("sphere", 1.0, n);
      case 2:
        return cylinder_mesh("cylinder", 1.0, random.uniform(0.1, 5.0), n);
      case 3:
        return capsule_mesh("capsule", 1.0, random.uniform(0.1, 5.0), n);
      default:
        return torus_mesh("torus", 1.0, random.uniform(0.1, 0.9), 3 + n, 3 + random.below(5));
    }
  }();
  const Matrix3d R = Eigen::AngleAxisd(random.uniform(-3.0, 3.0), random.vector().normalized()).matrix();
  const double size = std::pow(10.0, random.uniform(-3.0, 3.0));
  const Vector3d shift = random.vector(10.0);
  for (Vector3d& x : mesh.vertices) x = size * (R * x + shift);
  return mesh;
}

bool far_apart(const TriangleMesh& mesh, int a, int b) {
  std::vector<int> near_a, near_b;
  for (const Triangle& t : mesh.triangles) {
    if (std::find(t.begin(), t.end(), a) != t.end()) near_a.insert(near_a.end(), t.begin(), t.end());
    if (std::find(t.begin(), t.end(), b) != t.end()) near_b.insert(near_b.end(), t.begin(), t.end());
  }
  return std::find_first_of(near_a.begin(), near_a.end(), near_b.begin(), near_b.end()) == near_a.end();
}

constexpr int kMutations = 14;

Mutant mutate(TriangleMesh mesh, int mutation, Random& random) {
  const int triangles = static_cast<int>(mesh.triangles.size()),
            vertices = static_cast<int>(mesh.vertices.size());
  const int k = random.below(triangles), corner = random.below(3), vertex = mesh.triangles[k][corner];
  const Triangle t = mesh.triangles[k];
  const std::vector<std::string> at_triangle = {"mesh, triangle " + std::to_string(k) + ":"},
                                 at_vertex = {"mesh, vertex " + std::to_string(vertex)}, whole = {"mesh: "};
  switch (mutation) {
    case 0:  // a triangle is missing
      mesh.triangles.erase(mesh.triangles.begin() + k);
      return {mesh, {kOpen}, edges_of(t)};
    case 1:  // turned over
      std::swap(mesh.triangles[k][0], mesh.triangles[k][1]);
      return {mesh, {kWinding}, edges_of(t)};
    case 2:  // there twice
      mesh.triangles.insert(mesh.triangles.begin() + random.below(triangles), t);
      return {mesh, {kManyTriangles}, edges_of(t)};
    case 3: {  // no such vertex
      const int bad[] = {-1, vertices, vertices + 7, std::numeric_limits<int>::min(),
                         std::numeric_limits<int>::max()};
      mesh.triangles[k][corner] = bad[random.below(5)];
      return {mesh, {kIndex}, at_triangle};
    }
    case 4: {  // no such place
      const double bad[] = {kNan, kInfinity, -kInfinity};
      mesh.vertices[vertex][random.below(3)] = bad[random.below(3)];
      return {mesh, {kPosition}, at_vertex};
    }
    case 5:  // mirrored
      for (Vector3d& x : mesh.vertices) x[corner] *= -1.0;
      return {mesh, {kInsideOut}, whole};
    case 6: {  // pressed into a plane, by rounding not exactly
      const Vector3d normal = random.vector().normalized(), point = mesh.vertices[vertex];
      for (Vector3d& x : mesh.vertices) x -= normal.dot(x - point) * normal;
      return {mesh, {kFlat}, whole};
    }
    case 7:  // all in one point
      for (Vector3d& x : mesh.vertices) x = mesh.vertices[vertex];
      return {mesh, {kFlat}, whole};
    case 8:  // all turned over
      for (Triangle& other : mesh.triangles) std::swap(other[corner], other[(corner + 1) % 3]);
      return {mesh, {kInsideOut}, whole};
    case 9:  // a pocket without thickness on one triangle
      mesh.vertices.push_back(mesh.vertices[vertex] + random.vector());
      mesh.triangles.push_back(t);
      mesh.triangles.push_back({t[1], t[0], t[2]});
      return {mesh, {kManyTriangles}, edges_of(t)};
    case 10: {  // a corner goes elsewhere
      const int other = (vertex + 1 + random.below(vertices - 1)) % vertices;
      mesh.triangles[k][corner] = other;
      std::vector<std::string> elements = edges_of(t), more = edges_of(mesh.triangles[k]);
      elements.insert(elements.end(), more.begin(), more.end());
      return {mesh, {kOpen, kManyTriangles, kWinding}, elements};
    }
    case 11: {  // pinched: two vertices become one
      for (int other = 0; other < vertices; ++other)
        if (far_apart(mesh, vertex, other)) {
          rename(mesh, other, vertex);
          return {mesh, {kFan}, {at_vertex[0] + " of triangles"}};
        }
      return mutate(mesh, 12, random);
    }
    case 12: {  // a second body hangs on a vertex
      append(mesh, random_solid(random));
      rename(mesh, mesh.triangles.back()[0], vertex);
      return {mesh, {kFan}, {at_vertex[0] + " of triangles"}};
    }
    default:  // a hole around a vertex
      std::erase_if(mesh.triangles,
                    [&](const Triangle& x) { return std::find(x.begin(), x.end(), vertex) != x.end(); });
      return {mesh, {kOpen}, {"mesh, edge ("}};
  }
}

bool contains_one(const std::string& text, const std::vector<std::string>& parts) {
  return std::any_of(parts.begin(), parts.end(),
                     [&](const std::string& part) { return text.find(part) != text.npos; });
}

TEST(MeshCheckCampaign, EveryMutationIsRefusedByItsNameAndElement) {
  const int cases = test::campaign_cases(20000);
  std::array<int, kMutations> count{};
  for (int seed = 0; seed < cases; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    const int mutation = seed % kMutations;
    const TriangleMesh solid = random_solid(random);
    SCOPED_TRACE("seed " + std::to_string(seed) + ", mutation " + std::to_string(mutation));
    ASSERT_NO_THROW(check_closed_mesh("mesh", solid));
    const Mutant mutant = mutate(solid, mutation, random);
    std::string message = "accepted";
    try {
      check_closed_mesh("mesh", mutant.mesh);
    } catch (const InputError& error) {
      message = error.what();
    }
    EXPECT_TRUE(contains_one(message, mutant.classes)) << message << "\nexpected: " << mutant.classes[0];
    EXPECT_TRUE(contains_one(message, mutant.elements)) << message << "\nexpected: " << mutant.elements[0];
    ++count[mutation];
  }
  EXPECT_GT(*std::min_element(count.begin(), count.end()), 0);
}

TEST(MeshCheckCampaign, NamesAndOrderOfElementsDoNotMatter) {
  for (int seed = 0; seed < test::campaign_cases(5000); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(static_cast<std::uint64_t>(seed));
    TriangleMesh mesh = random_solid(random);
    for (Triangle& t : mesh.triangles) std::rotate(t.begin(), t.begin() + random.below(3), t.end());
    for (int i = static_cast<int>(mesh.triangles.size()); i-- > 1;)
      std::swap(mesh.triangles[i], mesh.triangles[random.below(i + 1)]);
    // another name for one vertex, one that nobody uses, a triangle that is none
    const int old = mesh.triangles[0][0], last = static_cast<int>(mesh.vertices.size());
    mesh.vertices.push_back(mesh.vertices[old]);
    rename(mesh, old, last);
    mesh.vertices[old] = random.vector(1e6);
    mesh.triangles.push_back({last, last, old});
    EXPECT_NO_THROW(check_closed_mesh("mesh", mesh));
  }
}

TEST(MeshCheck, AVolumeThatOverflowsIsNoVolume) {
  TriangleMesh mesh = cube();
  for (Vector3d& x : mesh.vertices) x *= 1e150;
  EXPECT_TRUE(refused("mesh: volume = inf m^3, expected a finite number", mesh));
}

TEST(MeshCheck, NoTrianglesAreNoClosedMesh) {
  EXPECT_TRUE(refused("mesh: number of triangles = 0, expected a closed mesh", TriangleMesh{}));
}

}  // namespace
}  // namespace feder
