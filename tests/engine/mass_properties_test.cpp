// Mass properties (notes C3-C5, C7-C9) against direct sums of angular momentum, quadrature, composition and
// closed forms.
#include "engine/mass_properties.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/check.h"
#include "engine/geometry/mesh_generators.h"
#include "tests/support/finite_difference.h"
#include "tests/support/random.h"
#include "tests/support/refused.h"

namespace feder {
namespace {

using std::numbers::pi;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double largest(const Eigen::MatrixXd& m) {
  return m.cwiseAbs().maxCoeff();
}

double difference(const MassProperties& a, const MassProperties& b) {
  return std::max({std::abs(a.mass - b.mass) / b.mass, largest(a.centre - b.centre),
                   largest(a.inertia - b.inertia) / largest(b.inertia)});
}

Matrix3d random_rotation(Random& random) {
  return Eigen::AngleAxisd(random.uniform(-3.0, 3.0), random.vector().normalized()).toRotationMatrix();
}

std::vector<PointMass> random_cloud(Random& random, int count) {
  std::vector<PointMass> points;
  for (int i = 0; i < count; ++i) points.push_back({random.uniform(0.1, 2.0), random.vector()});
  return points;
}

MassProperties random_body(Random& random) {
  return point_masses("cloud", random_cloud(random, 4 + random.below(8)));
}

/// sum r x m (w x r) about a point, for w = e_x, e_y, e_z: no inertia formula in it.
Matrix3d momentum_matrix(const std::vector<PointMass>& points, const Vector3d& about) {
  Matrix3d out = Matrix3d::Zero();
  for (const PointMass& p : points)
    for (int j = 0; j < 3; ++j) {
      const Vector3d r = p.position - about;
      out.col(j) += r.cross(p.mass * Vector3d::Unit(j).cross(r));
    }
  return out;
}

/// Three-point Gauss in a and b (polynomials to degree 5), eight angles (trigonometric to degree 7).
/// `point` gives a position and a weight for (a, b, angle); the weights are scaled to the mass.
template <class Point>
std::vector<PointMass> quadrature(double mass, Point&& point) {
  const double node[3] = {-std::sqrt(0.6), 0.0, std::sqrt(0.6)}, weight[3] = {5.0, 8.0, 5.0};
  std::vector<PointMass> out;
  double total = 0.0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 8; ++k) {
        out.push_back(point(node[i], node[j], 0.25 * pi * k));
        total += out.back().mass *= weight[i] * weight[j];
      }
  for (PointMass& p : out) p.mass *= mass / total;
  return out;
}

PointMass on_sphere(double radius, double height, double angle, double weight) {
  const double across = std::sqrt(1.0 - height * height);
  return {weight, radius * Vector3d(across * std::cos(angle), across * std::sin(angle), height)};
}

struct Mesh : TriangleMesh {
  void append(const Mesh& other, bool flipped) {
    const int first = static_cast<int>(vertices.size());
    vertices.insert(vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const auto& [a, b, c] : other.triangles)
      triangles.push_back({first + a, first + (flipped ? c : b), first + (flipped ? b : c)});
  }
  MassProperties properties(double density = 1.0) const { return solid_mesh("mesh", density, *this); }
};

Mesh box_between(const Vector3d& low, const Vector3d& high) {
  Mesh mesh{box_mesh("box", high - low)};
  for (Vector3d& x : mesh.vertices) x += 0.5 * (low + high);
  return mesh;
}

Mesh cube_mesh() {
  return {box_mesh("cube", Vector3d::Ones())};
}

Mesh ellipsoid_mesh(const Vector3d& half_axes, int n) {
  Mesh mesh{sphere_mesh("ellipsoid", 1.0, n)};
  for (Vector3d& x : mesh.vertices) x = half_axes.cwiseProduct(x);
  return mesh;
}

using test::refused;

testing::AssertionResult refused(const std::string& part, const Mesh& mesh) {
  return refused(part, [&] { (void)mesh.properties(); });
}

testing::AssertionResult refused(const std::string& part, const MassProperties& p) {
  return refused(part, [&] { check_inertia("body 7", p); });
}

TEST(PointMasses, InertiaTimesAngularVelocityIsTheAngularMomentum) {
  Random random(1);
  for (int trial = 0; trial < 500; ++trial) {
    const auto points = random_cloud(random, 2 + random.below(30));
    const MassProperties body = point_masses("cloud", points);
    const Matrix3d expected = momentum_matrix(points, body.centre);
    ASSERT_GT(largest(expected), 1e-3);
    EXPECT_LT(largest(body.inertia - expected), 1e-13 * largest(expected));  // 0: the same products
  }
}

TEST(PointMasses, TheBracketAsPrintedIsNoInertia) {
  // notes C3: r r^T E - r r^T vanishes; a mass on the first term alone leaves the second without it
  Random random(2);
  const auto points = random_cloud(random, 5);
  Matrix3d scanned = Matrix3d::Zero(), half_weighted = Matrix3d::Zero(), right = Matrix3d::Zero();
  for (const auto& [m, r] : points) {
    const Matrix3d E = Matrix3d::Identity(), rrT = r * r.transpose();
    scanned += m * (rrT * E - rrT);
    half_weighted += m * r.dot(r) * E - rrT;
    right += m * (r.dot(r) * E - rrT);
  }
  const Matrix3d expected = momentum_matrix(points, Vector3d::Zero());
  EXPECT_LT(largest(right - expected), 1e-14 * largest(expected));         // 5e-17
  EXPECT_GT(largest(scanned - expected), 0.9 * largest(expected));         // 1.0
  EXPECT_GT(largest(half_weighted - expected), 0.03 * largest(expected));  // 0.10
}

TEST(Shapes, AgreeWithQuadrature) {
  const double m = 2.3, r = 0.7, h = 1.9;
  auto ball = [&](double a, double b, double angle) {
    return on_sphere(0.5 * r * (1 + a), b, angle, (1 + a) * (1 + a));
  };
  auto shell = [&](double, double b, double angle) { return on_sphere(r, b, angle, 1.0); };
  auto cylinder = [&](double a, double b, double angle) {
    const double across = 0.5 * r * (1 + a);
    return PointMass{across, {across * std::cos(angle), across * std::sin(angle), 0.5 * h * b}};
  };
  auto rod = [&](double, double b, double) { return PointMass{1.0, {0, 0, 0.5 * h * b}}; };
  const std::pair<MassProperties, std::vector<PointMass>> cases[] = {
      {solid_sphere("ball", m, r), quadrature(m, ball)},
      {hollow_sphere("shell", m, r), quadrature(m, shell)},
      {solid_cylinder("cylinder", m, r, h), quadrature(m, cylinder)},
      {thin_rod("rod", m, h), quadrature(m, rod)}};
  for (const auto& [shape, points] : cases) {
    const Matrix3d expected = momentum_matrix(points, Vector3d::Zero());
    EXPECT_EQ(shape.mass, m);
    EXPECT_TRUE(shape.centre.isZero(0.0));
    ASSERT_GT(largest(expected), 0.1);
    EXPECT_LT(largest(shape.inertia - expected), 1e-14 * largest(expected));  // 9e-16
  }
}

TEST(Shapes, ABallIsMadeOfShells) {
  std::vector<MassProperties> shells;
  auto layer = [](double a, double, double) { return PointMass{(1 + a) * (1 + a), {0.5 * (1 + a), 0, 0}}; };
  for (const auto& [mass, x] : quadrature(1.0, layer)) shells.push_back(hollow_sphere("shell", mass, x.x()));
  EXPECT_LT(difference(combined("ball", shells), solid_sphere("ball", 1.0, 1.0)), 1e-14);  // 8e-16
}

TEST(Shapes, TheSmallMomentOfANeedleKeepsItsDigits) {
  const double r = 1e-7;  // beside a height of 1, tr(C) - C_zz would keep two digits
  EXPECT_NEAR(solid_cylinder("needle", 1.0, r, 1.0).inertia(2, 2) / (0.5 * r * r), 1.0, 1e-15);  // 0
}

TEST(Shapes, RefuseWhatIsNotPositiveByName) {
  for (double bad : {0.0, -1.0, kNan, kInfinity}) {
    EXPECT_TRUE(refused("b: mass = ", [&] { solid_box("b", bad, {1, 1, 1}); }));
    EXPECT_TRUE(refused("b: edge length z = ", [&] { solid_box("b", 1, {1, 1, bad}); }));
    EXPECT_TRUE(refused("b: mass = ", [&] { solid_sphere("b", bad, 1); }));
    EXPECT_TRUE(refused("b: radius = ", [&] { solid_sphere("b", 1, bad); }));
    EXPECT_TRUE(refused("b: radius = ", [&] { hollow_sphere("b", 1, bad); }));
    EXPECT_TRUE(refused("b: radius = ", [&] { solid_cylinder("b", 1, bad, 1); }));
    EXPECT_TRUE(refused("b: height = ", [&] { solid_cylinder("b", 1, 1, bad); }));
    EXPECT_TRUE(refused("b: length = ", [&] { thin_rod("b", 1, bad); }));
    EXPECT_TRUE(refused("mesh: density = ", [&] { (void)cube_mesh().properties(bad); }));
  }
}

TEST(Combined, RefusesAPartWithoutMassOrPlaceByName) {
  const Vector3d nowhere(0, kNan, 0);
  EXPECT_TRUE(refused("b, point 1: mass = -1 kg", [] { point_masses("b", {{1.0}, {-1.0}}); }));
  EXPECT_TRUE(refused("b, point 0: centre = nan m", [&] { point_masses("b", {{1.0, nowhere}}); }));
  EXPECT_TRUE(refused("b, part 1: mass = 0 kg", [] { combined("b", {{1.0}, {0.0}}); }));
  EXPECT_TRUE(refused("b: number of parts = 0", [] { combined("b", {}); }));
}

TEST(Moved, TurnsAndShiftsTheBodyAsItsPoints) {
  Random random(3);
  for (int trial = 0; trial < 100; ++trial) {
    auto points = random_cloud(random, 6);
    const Matrix3d R = random_rotation(random);
    const Vector3d shift = random.vector();
    const MassProperties body = moved(point_masses("cloud", points), R, shift);
    for (PointMass& p : points) p.position = R * p.position + shift;
    const Matrix3d expected = momentum_matrix(points, body.centre);
    EXPECT_LT(difference(body, point_masses("cloud", points)), 1e-14);       // 9e-16
    EXPECT_LT(largest(body.inertia - expected), 1e-14 * largest(expected));  // 1e-15
    EXPECT_EQ(largest(body.inertia - body.inertia.transpose()), 0.0);
  }
}

TEST(Moved, RefusesMirrorsScalesAndNan) {
  const MassProperties p = solid_sphere("ball", 1.0, 1.0);
  const Matrix3d E = Matrix3d::Identity();
  const Vector3d mirror(1, 1, -1);
  for (const Matrix3d& bad : {Matrix3d(mirror.asDiagonal()), Matrix3d(1.001 * E), Matrix3d(kNan * E)})
    EXPECT_THROW((void)moved(p, bad, Vector3d::Zero()), MisuseError);
}

TEST(Moved, RateOfATurningInertiaIsItsCommutatorWithTheAngularVelocity) {
  Random random(4);
  for (int trial = 0; trial < 20; ++trial) {
    const MassProperties body = random_body(random);
    const Matrix3d R0 = random_rotation(random);
    const Vector3d w = random.vector(2.0);
    auto turned = [&](const VectorXd& t) -> VectorXd {
      const Matrix3d R = Eigen::AngleAxisd(t[0] * w.norm(), w.normalized()) * R0;
      return moved(body, R, Vector3d::Zero()).inertia.reshaped();
    };
    const Matrix3d I = turned(VectorXd::Zero(1)).reshaped(3, 3);
    const Matrix3d rate = finite_jacobian(turned, VectorXd::Zero(1), 1e-3).reshaped(3, 3);
    Matrix3d wI;  // [w]x I, and I [w]x = -([w]x I)^T
    for (int j = 0; j < 3; ++j) wI.col(j) = w.cross(I.col(j));
    ASSERT_GT(largest(rate), 0.05 * largest(I));
    EXPECT_LT(largest(wI + wI.transpose() - rate), 1e-9 * largest(I));  // 3e-11
    EXPECT_LT(largest(rate * w - w.cross(I * w)), 1e-9 * largest(I));   // 7e-12
    // notes C4 as printed, R' I0 R^T + R I0' R^T: I0 is constant, half of the rate is missing
    EXPECT_GT(largest(wI - rate), 0.05 * largest(I));  // at least 1
  }
}

TEST(Covariance, IsTheSecondMomentAndGoesBackToTheInertia) {
  Random random(5);
  for (int trial = 0; trial < 200; ++trial) {
    const auto points = random_cloud(random, 7);
    const MassProperties body = point_masses("cloud", points);
    Matrix3d C = Matrix3d::Zero();
    for (const auto& [m, r] : points) C += m * (r - body.centre) * (r - body.centre).transpose();
    EXPECT_LT(largest(covariance_from_inertia(body.inertia) - C), 1e-14 * largest(C));  // 7e-16
    EXPECT_LT(largest(inertia_from_covariance(C) - body.inertia), 1e-14 * largest(C));  // 7e-16
  }
}

TEST(Covariance, HasTheEigenvectorsOfTheInertiaInReverseOrder) {
  Random random(6);
  for (int trial = 0; trial < 200; ++trial) {
    const MassProperties body = random_body(random);
    const Matrix3d C = covariance_from_inertia(body.inertia);
    const Vector3d values = Eigen::SelfAdjointEigenSolver<Matrix3d>(C).eigenvalues();
    const auto [axes, moments] = principal_axes(body);
    ASSERT_GT(values[2] - values[0], 1e-2);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(moments[i], C.trace() - values[2 - i], 1e-14 * moments[2]);                 // 1e-15
      EXPECT_LT((C * axes.col(i) - values[2 - i] * axes.col(i)).norm(), 1e-14 * moments[2]);  // 6e-16
    }
  }
}

TEST(PrincipalAxes, AreARotationThatRestoresTheInertia) {
  Random random(7);
  std::vector<MassProperties> bodies = {solid_sphere("ball", 1, 1), solid_cylinder("cylinder", 1, 2, 1),
                                        solid_box("box", 1, {3, 2, 1}), thin_rod("rod", 1, 1)};
  for (int trial = 0; trial < 200; ++trial) bodies.push_back(random_body(random));
  for (const MassProperties& body : bodies) {
    const auto [axes, moments] = principal_axes(body);
    EXPECT_NEAR(axes.determinant(), 1.0, 1e-14);  // 2e-15
    EXPECT_TRUE(moments[0] <= moments[1] && moments[1] <= moments[2]);
    EXPECT_LT(largest(axes * moments.asDiagonal() * axes.transpose() - body.inertia),
              1e-14 * moments[2]);  // 2e-15
  }
}

TEST(Steiner, AgreesWithTheDirectSumAboutTheOtherPoint) {
  Random random(8);
  for (int trial = 0; trial < 200; ++trial) {
    const auto points = random_cloud(random, 8);
    const MassProperties body = point_masses("cloud", points);
    const Vector3d about = random.vector(5.0);
    const Matrix3d expected = momentum_matrix(points, about);
    ASSERT_GT(largest(expected - body.inertia), 0.1);
    EXPECT_LT(largest(inertia_about(body, about) - expected), 1e-13 * largest(expected));  // 4e-16
  }
}

TEST(Steiner, MovingAwayNeverLowersAMoment) {
  Random random(9);
  double least = 0.0, least_with_minus = 0.0, most = 0.0;
  auto moments = [](const Matrix3d& I) { return Eigen::SelfAdjointEigenSolver<Matrix3d>(I).eigenvalues(); };
  for (int trial = 0; trial < 200; ++trial) {
    const MassProperties body = random_body(random);
    const Vector3d direction = random.vector();
    Matrix3d before = body.inertia;
    for (double way : {0.1, 1.0, 10.0}) {
      const Matrix3d I = inertia_about(body, body.centre + way * direction);
      const Vector3d gain = (moments(I) - moments(before)) / I.norm();
      least = std::min(least, gain.minCoeff());
      most = std::max(most, gain.maxCoeff());
      least_with_minus = std::min(least_with_minus, moments(2.0 * body.inertia - I).minCoeff());
      before = I;
    }
  }
  EXPECT_GT(most, 0.1);
  EXPECT_GT(least, -1e-14);           // 0: none is lowered
  EXPECT_LT(least_with_minus, -1.0);  // -3e3: the other sign of d^2 E - d d^T
}

TEST(Combined, TwoHalfBoxesAreOneBox) {
  Random random(10);
  const Vector3d whole(3.0, 1.3, 0.7), half(1.5, 1.3, 0.7);
  const MassProperties part = solid_box("half", 1.0, half), box = solid_box("box", 2.0, whole);
  for (int trial = 0; trial < 50; ++trial) {
    const Matrix3d R = random_rotation(random);
    const Vector3d shift = random.vector(), offset = R * Vector3d(0.75, 0, 0);
    const MassProperties both =
        combined("both", {moved(part, R, shift + offset), moved(part, R, shift - offset)});
    EXPECT_LT(difference(both, moved(box, R, shift)), 1e-14);  // 5e-16
  }
  EXPECT_GT(largest(box.inertia - 2.0 * part.inertia), 1.0);  // what the shifts contribute
}

TEST(Combined, DoesNotDependOnOrderOrGrouping) {
  Random random(11);
  std::vector<MassProperties> parts;
  for (int i = 0; i < 9; ++i)
    parts.push_back(moved(random_body(random), random_rotation(random), random.vector()));
  const MassProperties body = combined("body", parts);
  for (int trial = 0; trial < 100; ++trial) {
    for (int i = 8; i > 0; --i) std::swap(parts[i], parts[random.below(i + 1)]);
    const std::vector<MassProperties> front(parts.begin(), parts.begin() + 4),
        back(parts.begin() + 4, parts.end());
    EXPECT_LT(difference(combined("body", parts), body), 1e-14);  // 2e-16
    EXPECT_LT(difference(combined("body", {combined("a", front), combined("b", back)}), body),
              1e-14);  // 3e-16
  }
}

TEST(SolidMesh, ACubeIsExact) {
  const MassProperties cube = cube_mesh().properties();
  EXPECT_EQ(cube.mass, 1.0);
  EXPECT_LT(largest(cube.centre), 1e-16);                                // 0; 2e-18 with FMA
  EXPECT_LT(largest(cube.inertia - Matrix3d::Identity() / 6.0), 1e-16);  // 0
}

TEST(SolidMesh, ATurnedBoxFarAwayIsTheBox) {
  Random random(12);
  for (double distance : {1.0, 1e3, 1e6}) {
    const Vector3d l(0.5, 2.0, 1.0), shift = distance * random.vector();
    const Matrix3d R = random_rotation(random);
    Mesh mesh = box_between(-0.5 * l, 0.5 * l);
    for (Vector3d& x : mesh.vertices) x = R * x + shift;
    const double rounding = 1e-14 + 1e-15 * distance;  // of the coordinates; 4e-2 of it
    EXPECT_LT(difference(mesh.properties(3.0), moved(solid_box("box", 3.0, l), R, shift)), rounding)
        << distance;
  }
}

TEST(SolidMesh, ConvergesWithOrderTwoInTheEdgeLength) {
  for (const Vector3d& s : {Vector3d(1, 1, 1), Vector3d(1, 2, 0.5)}) {
    const double mass = 4.0 / 3.0 * pi * s.prod();
    const Matrix3d exact = inertia_from_covariance(Vector3d(mass / 5.0 * s.cwiseAbs2()).asDiagonal());
    Vector3d error[2];
    for (int finer : {0, 1}) {
      const MassProperties p = ellipsoid_mesh(s, 32 << finer).properties();
      error[finer] = {mass - p.mass, largest(exact - p.inertia), exact.trace() - p.inertia.trace()};
      EXPECT_LT(largest(p.centre), 1e-14);  // 5e-17
    }
    for (int i = 0; i < 3; ++i) {
      const double order = std::log2(error[0][i] / error[1][i]);
      ASSERT_GT(error[1][i], 1e-4 * mass);  // inscribed: at least 7e-4
      EXPECT_GT(order, 1.98);               // 1.996 to 1.999
      EXPECT_LT(order, 2.02);
    }
  }
}

TEST(SolidMesh, AnInnerSurfaceWoundTheOtherWayIsACavity) {
  const Mesh outer = box_between({0, 0, 0}, {3, 2, 2}),
             inner = box_between({0.5, 0.25, 0.5}, {1.5, 1.25, 0.75});
  Mesh hollow = outer;
  hollow.append(inner, true);
  const MassProperties p = hollow.properties(2.0);
  EXPECT_NEAR(p.mass, 2.0 * (12.0 - 0.25), 1e-13);  // 0
  EXPECT_GT(p.centre.x(), 1.505);
  // filled again it is the full box
  const MassProperties full = moved(solid_box("box", 24.0, {3, 2, 2}), Matrix3d::Identity(), {1.5, 1, 1});
  EXPECT_LT(difference(combined("full", {p, inner.properties(2.0)}), full), 1e-14);  // 3e-16
}

TEST(SolidMesh, UnusedVerticesAndTrianglesWithoutAreaChangeNothing) {
  Mesh mesh = cube_mesh();
  mesh.vertices.emplace_back(1e9, 0, 0);
  mesh.vertices.emplace_back(-0.5, 0.0, 0.0);  // halves the diagonal 0-6, seen by one of its triangles only
  mesh.triangles[0] = {0, 4, 9};
  mesh.triangles.insert(mesh.triangles.end(), {{4, 6, 9}, {0, 9, 6}, {3, 3, 7}});
  EXPECT_LT(difference(mesh.properties(), cube_mesh().properties()), 1e-15);  // 2e-16
}

TEST(SolidMesh, RefusesAnIndexOutOfRange) {
  for (int bad : {-1, 8}) {
    Mesh mesh = cube_mesh();
    mesh.triangles[5][1] = bad;
    EXPECT_TRUE(refused(
        "mesh, triangle 5: vertex index = " + std::to_string(bad) + ", expected 0 <= index < 8", mesh));
  }
}

TEST(SolidMesh, RefusesAVertexThatIsNotFinite) {
  Mesh mesh = cube_mesh();
  mesh.vertices[6].y() = kNan;
  EXPECT_TRUE(refused("mesh, vertex 6: position = nan m, expected a finite number", mesh));
}

TEST(SolidMesh, RefusesAVolumeThatOverflows) {
  const Vector3d corner = Vector3d::Constant(1e150);
  EXPECT_TRUE(refused("mesh: volume = inf m^3, expected a finite number", box_between(-corner, corner)));
}

TEST(SolidMesh, RefusesAnOpenMesh) {
  Mesh mesh = cube_mesh();
  mesh.triangles.pop_back();  // {4, 7, 6}
  EXPECT_TRUE(
      refused("edge (4, 6) of triangle 0: number of triangles = 1, expected 2: the mesh is open", mesh));
  EXPECT_TRUE(refused("mesh: number of triangles = 0, expected a closed mesh", Mesh{}));
}

TEST(SolidMesh, RefusesAnEdgeOfThreeTriangles) {
  Mesh mesh = cube_mesh();
  mesh.triangles.push_back({0, 1, 6});  // a fin on the edge (0, 1)
  EXPECT_TRUE(
      refused("edge (0, 1) of triangle 4: number of triangles = 3, expected 2: the mesh is not", mesh));
}

TEST(SolidMesh, RefusesATriangleWoundAgainstItsNeighbours) {
  Mesh mesh = cube_mesh();
  std::swap(mesh.triangles[4][1], mesh.triangles[4][2]);
  EXPECT_TRUE(refused("edge (0, 1) of triangle 4 and triangle 9: triangles in one direction = 2", mesh));
}

TEST(SolidMesh, RefusesAMeshThatIsInsideOut) {
  Mesh mesh;
  mesh.append(cube_mesh(), true);
  EXPECT_TRUE(refused("mesh: volume = -1 m^3, expected a value > 0: the mesh is inside out", mesh));
}

TEST(SolidMesh, RefusesAMeshWithoutVolume) {
  Random random(13);
  for (double distance : {0.0, 1.0, 1e6}) {
    Mesh mesh;
    for (int i = 0; i < 3; ++i) mesh.vertices.push_back(random.vector() + distance * Vector3d(1, 2, 3));
    mesh.triangles = {{0, 1, 2}, {0, 2, 1}};
    EXPECT_TRUE(refused("the mesh is flat", mesh));
    // a flat pillow: the rounding of a vertex within the plane is no thickness
    mesh.vertices.push_back(0.3 * mesh.vertices[0] + 0.5 * mesh.vertices[1] + 0.2 * mesh.vertices[2]);
    mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    EXPECT_TRUE(refused("the mesh is flat", mesh));
  }
  EXPECT_NO_THROW((void)box_between({1, 1, 1}, {2, 2, 1 + 1e-9}).properties());
}

TEST(SolidMesh, RefusesACavityOutsideTheBody) {
  Mesh mesh = box_between({0, 0, 0}, {2, 1, 1});
  mesh.append(box_between({5, 0, 0}, {6, 1, 1}), true);
  EXPECT_TRUE(refused("mesh: smallest principal moment = -", mesh));
}

TEST(CheckInertia, AcceptsEveryCloudOfPoints) {
  Random random(14);
  for (int trial = 0; trial < 2000; ++trial) {
    auto points = random_cloud(random, 3 + random.below(40));
    for (PointMass& p : points) p.position.z() *= trial % 2;  // every other cloud a flat plate: equality
    const Matrix3d R = random_rotation(random);
    EXPECT_NO_THROW(check_inertia("body", moved(point_masses("cloud", points), R, random.vector(1e3))));
  }
}

TEST(CheckInertia, RefusesAMomentAboveTheSumOfTheOthers) {
  Random random(15);
  for (int trial = 0; trial < 200; ++trial) {
    MassProperties body = random_body(random);
    const PrincipalAxes p = principal_axes(body);
    auto with_largest = [&](double moment) {
      const Matrix3d I =
          p.axes * Vector3d(p.moments[0], p.moments[1], moment).asDiagonal() * p.axes.transpose();
      body.inertia = 0.5 * (I + I.transpose());
      return body;
    };
    const double sum = p.moments[0] + p.moments[1];
    EXPECT_NO_THROW(check_inertia("body", with_largest((1.0 - 1e-10) * sum)));
    for (double excess : {1e-10, 1.0})
      EXPECT_TRUE(refused("body 7: sum of the smaller two principal moments over the largest = 0.",
                          with_largest((1.0 + excess) * sum)));
  }
}

TEST(CheckInertia, RefusesARodAndAPointByName) {
  Random random(16);
  for (int trial = 0; trial < 100; ++trial) {
    const Matrix3d R = random_rotation(random);
    EXPECT_TRUE(refused("a thin rod or a point", moved(thin_rod("rod", 2.0, 3.0), R, random.vector())));
  }
  EXPECT_TRUE(refused("body 7: smallest principal moment = 0 kg m^2", MassProperties{1.0}));
  EXPECT_NO_THROW(check_inertia("body", solid_cylinder("wire", 1.0, 1e-5, 1.0)));
}

TEST(CheckInertia, RefusesWhatIsNegativeOrNotSymmetric) {
  MassProperties negative = solid_box("box", 1.0, {1, 2, 3}), skew = negative;
  negative.inertia *= -1.0;
  EXPECT_TRUE(refused("body 7: smallest principal moment = -1.08", negative));
  skew.inertia(0, 2) += 1e-3;
  EXPECT_TRUE(refused("body 7: inertia(2, 0) minus its transpose = -0.001", skew));
}

TEST(CheckInertia, RefusesWhatIsNotFinite) {
  for (double bad : {kNan, kInfinity}) {
    MassProperties p = solid_box("box", 1.0, {1, 2, 3});
    p.inertia(1, 0) = bad;
    EXPECT_TRUE(refused("body 7: inertia = ", p));
    EXPECT_THROW((void)principal_axes(p), MisuseError);
    p.centre.z() = bad;
    EXPECT_TRUE(refused("body 7: centre = ", p));
    p.mass = bad;
    EXPECT_TRUE(refused("body 7: mass = ", p));
  }
}

}  // namespace
}  // namespace feder
