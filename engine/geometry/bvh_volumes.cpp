// Sphere: round the middle of the box. Oriented box: axes are the eigenvectors of the covariance of the
// surface (every triangle with its area; of the corners where there is no area), the extents along them
// centre the box.
#include "engine/geometry/bvh_volumes.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace feder {
namespace {

// Rounding of a pose and of the projections in a test, in units of the last place of the largest coordinate.
constexpr double kSlack = 64.0 * std::numeric_limits<double>::epsilon();

// integral of x x^T over the triangle a b c: area/12 (a a^T + b b^T + c c^T + s s^T), s = a + b + c
Matrix3d covariance(const Corners* triangles, int count, const Vector3d& origin) {
  Matrix3d second = Matrix3d::Zero(), points = Matrix3d::Zero();
  Vector3d first = Vector3d::Zero();
  double area = 0.0;
  for (int k = 0; k < count; ++k) {
    const Vector3d a = triangles[k][0] - origin, b = triangles[k][1] - origin, c = triangles[k][2] - origin;
    const double weight = (b - a).cross(c - a).norm();
    const Vector3d s = a + b + c;
    const Matrix3d squares = a * a.transpose() + b * b.transpose() + c * c.transpose();
    points += squares;
    second += weight / 12.0 * (squares + s * s.transpose());
    first += weight / 3.0 * s;
    area += weight;
  }
  return area > 0.0 ? Matrix3d(second - first * first.transpose() / area) : points;
}

}  // namespace

Aabb merged(const Aabb& a, const Aabb& b) {
  return {a.min.cwiseMin(b.min), a.max.cwiseMax(b.max)};
}

void fit_volume(const Corners* triangles, int count, Aabb& out) {
  out.min = out.max = triangles[0][0];
  for (int k = 0; k < count; ++k)
    for (const Vector3d& x : triangles[k]) out.min = out.min.cwiseMin(x), out.max = out.max.cwiseMax(x);
}

void fit_volume(const Corners* triangles, int count, Sphere& out) {
  Aabb box;
  fit_volume(triangles, count, box);
  out.centre = 0.5 * (box.min + box.max);
  double radius_squared = 0.0;
  for (int k = 0; k < count; ++k)
    for (const Vector3d& x : triangles[k])
      radius_squared = std::max(radius_squared, (x - out.centre).squaredNorm());
  out.radius = std::sqrt(radius_squared);
}

void fit_volume(const Corners* triangles, int count, Obb& out) {
  Aabb box;
  fit_volume(triangles, count, box);
  const Vector3d origin = 0.5 * (box.min + box.max);
  const Matrix3d C = covariance(triangles, count, origin);
  const double scale = C.cwiseAbs().maxCoeff();
  out.axes = Matrix3d::Identity();
  if (scale > 0.0) out.axes = Eigen::SelfAdjointEigenSolver<Matrix3d>(C / scale).eigenvectors();
  if (out.axes.determinant() < 0.0) out.axes.col(0) *= -1.0;
  Vector3d low = out.axes.transpose() * (triangles[0][0] - origin), high = low;
  for (int k = 0; k < count; ++k)
    for (const Vector3d& x : triangles[k]) {
      const Vector3d along = out.axes.transpose() * (x - origin);
      low = low.cwiseMin(along);
      high = high.cwiseMax(along);
    }
  out.centre = origin + out.axes * (0.5 * (low + high));
  out.half = 0.5 * (high - low);
}

double reach_of(const Sphere& ball) {
  return ball.centre.norm() + ball.radius;
}
double reach_of(const Aabb& box) {
  return box.min.cwiseAbs().cwiseMax(box.max.cwiseAbs()).norm();
}
double reach_of(const Obb& box) {
  return box.centre.norm() + box.half.norm();
}

Relative relative(const Pose& a, const Pose& b, double reach) {
  Relative out;
  out.rotation = a.rotation.transpose() * b.rotation;
  out.size = out.rotation.cwiseAbs();
  out.position = a.rotation.transpose() * (b.position - a.position);
  out.turned = out.rotation != Matrix3d::Identity();
  out.slack = kSlack * (reach + out.position.norm());
  return out;
}

BoxGaps box_gaps(const Obb& a, const Obb& b, const Relative& frame) {
  const Matrix3d axes = a.axes.transpose() * frame.rotation * b.axes;
  const Vector3d centre = a.axes.transpose() * (frame(b.centre) - a.centre);
  return box_gaps(a.half, b.half, centre, axes, axes.cwiseAbs());
}

}  // namespace feder
