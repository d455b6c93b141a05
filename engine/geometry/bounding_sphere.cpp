// c = (1/n) sum p_i, r^2 = max |p_i - c|^2 (notes A2). Sums and squares are taken of 2^-e p with e the
// exponent of the largest coordinate, so that nothing overflows and no radius is lost below the smallest
// square.
#include "engine/geometry/bounding_sphere.h"

#include <algorithm>
#include <cmath>

#include "engine/check.h"

namespace feder {
namespace {

// The largest coordinate in magnitude.
double reach_of(std::span<const Vector3d> points) {
  double reach = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (double x : points[i])
      if (!std::isfinite(x)) require_finite("point " + std::to_string(i), "coordinate", x, "m");
    reach = std::max(reach, points[i].cwiseAbs().maxCoeff());
  }
  return reach;
}

}  // namespace

Sphere bounding_sphere(std::span<const Vector3d> points) {
  if (points.empty()) return {};
  const double reach = reach_of(points);
  const int exponent = reach > 0.0 ? std::ilogb(reach) : 0;
  const double half = std::ldexp(1.0, -exponent / 2), other_half = std::ldexp(1.0, -exponent + exponent / 2);
  auto scaled = [&](const Vector3d& p) -> Vector3d { return p * half * other_half; };

  // mean, from the first point on, then the farthest point
  const Vector3d first = scaled(points[0]);
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : points) mean += scaled(p) - first;
  mean /= static_cast<double>(points.size());
  double farthest = 0.0;
  for (const Vector3d& p : points) farthest = std::max(farthest, (scaled(p) - first - mean).squaredNorm());
  return {(first + mean) / half / other_half, std::sqrt(farthest) / half / other_half};
}

}  // namespace feder
