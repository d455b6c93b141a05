// Mass properties through the covariance C = integral of x x^T dm about a point (notes C3, C5, C7, C8, C9):
//   I = integral of (x^T x E - x x^T) dm = tr(C) E - C        C = (tr(I)/2) E - I
// Shift by d from the centre: C + m d d^T. Composition about the joint centre: sum_k (C_k + m_k d_k d_k^T).
// Shapes: C is diagonal. Box m l_i^2/12; ball m r^2/5; shell m r^2/3; cylinder m r^2/4 across, m h^2/12
// along. Mesh: engine/geometry/mesh_moments.cpp.
#include "engine/mass_properties.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include "engine/check.h"
#include "engine/geometry/mesh_check.h"
#include "engine/geometry/mesh_moments.h"

namespace feder {
namespace {

// What composition and rotation of many parts may leave of a zero or of an equality, relative.
constexpr double kRounding = 1e-12;

MassProperties centred(const std::string& where, double mass, const Vector3d& covariance_per_mass) {
  require_positive(where, "mass", mass, "kg");
  const Matrix3d C = (mass * covariance_per_mass).asDiagonal();
  return {mass, Vector3d::Zero(), inertia_from_covariance(C)};
}

void check_numbers(const std::string& place, const MassProperties& p) {
  require_positive(place, "mass", p.mass, "kg");
  for (double entry : p.centre) require_finite(place, "centre", entry, "m");
  for (double entry : p.inertia.reshaped()) require_finite(place, "inertia", entry, "kg m^2");
}

// Notes C8; `kind` is what the parts are called in messages.
MassProperties composed(const std::string& where, const std::string& kind,
                        const std::vector<MassProperties>& parts) {
  if (parts.empty()) fail_input(where, "number of " + kind + "s", 0, "", "at least 1");
  const std::string place = where + ", " + kind + " ";
  MassProperties out;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    check_numbers(place + std::to_string(k), parts[k]);
    out.mass += parts[k].mass;
    out.centre += parts[k].mass * parts[k].centre;
  }
  out.centre /= out.mass;

  // sum_k I_k + m_k (d_k^2 E - d_k d_k^T): an error of the centre enters squared only
  for (const MassProperties& part : parts) out.inertia += inertia_about(part, out.centre);
  return out;
}

}  // namespace

// Diagonal without tr(C) - C_ii, which would lose the small moment of a needle.
Matrix3d inertia_from_covariance(const Matrix3d& covariance) {
  Matrix3d I = -covariance;
  for (int i = 0; i < 3; ++i)
    I(i, i) = covariance((i + 1) % 3, (i + 1) % 3) + covariance((i + 2) % 3, (i + 2) % 3);
  return I;
}

Matrix3d covariance_from_inertia(const Matrix3d& inertia) {
  return 0.5 * inertia.trace() * Matrix3d::Identity() - inertia;
}

MassProperties solid_box(const std::string& where, double mass, const Vector3d& edges) {
  for (int c = 0; c < 3; ++c) require_positive(where, std::string("edge length ") + "xyz"[c], edges[c], "m");
  return centred(where, mass, edges.cwiseAbs2() / 12.0);
}

MassProperties solid_sphere(const std::string& where, double mass, double radius) {
  require_positive(where, "radius", radius, "m");
  return centred(where, mass, Vector3d::Constant(radius * radius / 5.0));
}

MassProperties hollow_sphere(const std::string& where, double mass, double radius) {
  require_positive(where, "radius", radius, "m");
  return centred(where, mass, Vector3d::Constant(radius * radius / 3.0));
}

MassProperties solid_cylinder(const std::string& where, double mass, double radius, double height) {
  require_positive(where, "radius", radius, "m");
  require_positive(where, "height", height, "m");
  return centred(where, mass, {radius * radius / 4.0, radius * radius / 4.0, height * height / 12.0});
}

MassProperties thin_rod(const std::string& where, double mass, double length) {
  require_positive(where, "length", length, "m");
  return centred(where, mass, {0.0, 0.0, length * length / 12.0});
}

MassProperties point_masses(const std::string& where, const std::vector<PointMass>& points) {
  std::vector<MassProperties> parts;
  parts.reserve(points.size());
  for (const PointMass& point : points) parts.push_back({point.mass, point.position, Matrix3d::Zero()});
  return composed(where, "point", parts);
}

MassProperties solid_mesh(const std::string& where, double density, const TriangleMesh& mesh) {
  require_positive(where, "density", density, "kg/m^3");
  check_closed_mesh(where, mesh);

  // centre from the middle of the bounding box, second moments about that centre: nothing large is subtracted
  const Vector3d middle = used_bounds(mesh).center();
  const MeshMoments rough = mesh_moments(mesh, middle);
  const Vector3d centre = middle + rough.first / rough.volume;
  const MeshMoments exact = mesh_moments(mesh, centre);
  MassProperties out{density * exact.volume, centre, inertia_from_covariance(density * exact.second)};
  check_inertia(where, out);
  return out;
}

MassProperties moved(const MassProperties& p, const Matrix3d& rotation, const Vector3d& translation) {
  FEDER_CHECK(
      (rotation.transpose() * rotation - Matrix3d::Identity()).norm() < 1e-10 && rotation.determinant() > 0.0,
      "the matrix is not a rotation: R^T R = E with determinant +1");
  const Matrix3d I = rotation * p.inertia * rotation.transpose();
  return {p.mass, rotation * p.centre + translation, 0.5 * (I + I.transpose())};
}

MassProperties combined(const std::string& where, const std::vector<MassProperties>& parts) {
  return composed(where, "part", parts);
}

Matrix3d inertia_about(const MassProperties& p, const Vector3d& point) {
  const Vector3d d = p.centre - point;
  return p.inertia + inertia_from_covariance(p.mass * d * d.transpose());
}

PrincipalAxes principal_axes(const MassProperties& p) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(p.inertia);
  FEDER_CHECK(p.inertia.allFinite() && solver.info() == Eigen::Success, "the inertia is not finite");
  PrincipalAxes out{solver.eigenvectors(), solver.eigenvalues()};
  if (out.axes.determinant() < 0.0) out.axes.col(2) *= -1.0;
  return out;
}

void check_inertia(const std::string& where, const MassProperties& p) {
  check_numbers(where, p);
  const double size = p.inertia.cwiseAbs().maxCoeff();
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const double skew = p.inertia(i, j) - p.inertia(j, i);
    if (std::abs(skew) > kRounding * size)
      fail_input(where, "inertia(" + std::to_string(i) + ", " + std::to_string(j) + ") minus its transpose",
                 skew, "kg m^2", "0: an inertia is symmetric");
  }
  const Vector3d moments = principal_axes(p).moments;
  if (moments[0] < -kRounding * size)
    fail_input(where, "smallest principal moment", moments[0], "kg m^2", "a value > 0");
  if (moments[0] <= kRounding * size)
    fail_input(
        where, "smallest principal moment", moments[0], "kg m^2",
        "a value > 0: a thin rod or a point has no inertia about its axis, its mass matrix is singular");
  if (moments[0] + moments[1] < (1.0 - kRounding) * moments[2])
    fail_input(where, "sum of the smaller two principal moments over the largest",
               (moments[0] + moments[1]) / moments[2], "", "at least 1, as for every distribution of mass");
}

}  // namespace feder
