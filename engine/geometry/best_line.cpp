// Best line and covariance (notes A5, A6), p measured from the mean:
//   f(v) = sum |p x v|^2 = sum p^2 v^2 - (p^T v)^2 = tr(C) - v^T C v  for |v| = 1,   C = sum p p^T
// Lagrange: C v = lambda v. Of the three axes the one of the largest lambda is the minimum of f, the middle
// one a saddle, the last a maximum: turning from axis i towards axis j the second difference of f is 2
// (lambda_i - lambda_j). f of an axis is the sum of the two other eigenvalues, which tr(C) - lambda would
// lose. Surface, per triangle (a, b, c) of area S about o:  int x = S (a + b + c)/3,
//   int x x^T = S/12 (a a^T + b b^T + c c^T + s s^T),  s = a + b + c.
#include "engine/geometry/best_line.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

#include "engine/check.h"

namespace feder {
namespace {

// Eigenvalues closer than this, relative to the largest, are equal to rounding.
constexpr double kEqual = 1e-14;

void check_finite(const Spread& spread) {
  FEDER_CHECK(spread.mean.allFinite() && spread.covariance.allFinite(), "the covariance is not finite");
}

}  // namespace

Spread point_spread(std::span<const Vector3d> points) {
  FEDER_CHECK(!points.empty(), "a covariance needs at least one point");
  Spread out;
  out.weight = static_cast<double>(points.size());

  // mean, from the first point: far from the origin nothing is lost
  const Vector3d origin = points[0];
  Vector3d offset = Vector3d::Zero();
  for (const Vector3d& p : points) offset += p - origin;
  offset /= out.weight;
  out.mean = origin + offset;

  // C = sum p p^T of the centred points
  for (const Vector3d& p : points) {
    const Vector3d d = (p - origin) - offset;
    out.covariance += d * d.transpose();
  }
  check_finite(out);
  return out;
}

Spread surface_spread(const TriangleMesh& mesh, std::span<const int> triangles) {
  FEDER_CHECK(!triangles.empty(), "a covariance needs at least one triangle");
  const Vector3d origin = mesh.vertices[mesh.triangles[triangles[0]][0]];
  const auto corner = [&](int k, int i) -> Vector3d { return mesh.vertices[mesh.triangles[k][i]] - origin; };
  const auto area = [&](int k) {
    return 0.5 * (corner(k, 1) - corner(k, 0)).cross(corner(k, 2) - corner(k, 0)).norm();
  };
  Spread out;
  Vector3d offset = Vector3d::Zero();

  // area and mean
  for (int k : triangles) {
    const double S = area(k);
    out.weight += S;
    offset += S / 3.0 * (corner(k, 0) + corner(k, 1) + corner(k, 2));
  }
  if (out.weight > 0.0) offset /= out.weight;
  out.mean = origin + offset;

  // second moments about the mean
  for (int k : triangles) {
    const Vector3d a = corner(k, 0) - offset, b = corner(k, 1) - offset, c = corner(k, 2) - offset,
                   s = a + b + c;
    out.covariance +=
        area(k) / 12.0 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose());
  }
  check_finite(out);
  return out;
}

Spread surface_spread(const TriangleMesh& mesh) {
  std::vector<int> all(mesh.triangles.size());
  std::iota(all.begin(), all.end(), 0);
  return surface_spread(mesh, all);
}

CriticalAxes critical_axes(const Matrix3d& covariance) {
  FEDER_CHECK(covariance.allFinite(), "the covariance is not finite");
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(covariance);
  CriticalAxes out;

  // eigenvectors, the largest eigenvalue first
  out.axes = solver.eigenvectors().rowwise().reverse();
  if (out.axes.determinant() < 0.0) out.axes.col(2) *= -1.0;
  const Vector3d lambda = solver.eigenvalues().reverse().cwiseMax(0.0);
  out.squared_distance = {lambda[1] + lambda[2], lambda[0] + lambda[2], lambda[0] + lambda[1]};

  // signs of the second differences towards the two others
  for (int i = 0; i < 3; ++i) {
    int rising = 0, falling = 0;
    for (int j : {(i + 1) % 3, (i + 2) % 3}) {
      const double second_difference = 2.0 * (lambda[i] - lambda[j]);
      rising += second_difference > kEqual * lambda[0];
      falling += second_difference < -kEqual * lambda[0];
    }
    out.kind[i] = rising + falling < 2 ? AxisKind::kDegenerate
                  : rising == 2        ? AxisKind::kMinimum
                  : falling == 2       ? AxisKind::kMaximum
                                       : AxisKind::kSaddle;
  }
  return out;
}

Line best_line(std::span<const Vector3d> points) {
  const Spread spread = point_spread(points);
  return {spread.mean, critical_axes(spread.covariance).axes.col(0)};
}

}  // namespace feder
