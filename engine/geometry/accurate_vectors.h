// Differences without error and cross products accurate in every component, however nearly parallel the
// factors: the direction of an axis is then as good as its numbers, and so is what the axis separates.
#pragma once

#include <cmath>

#include "engine/geometry/bounding_volumes.h"

namespace feder {

/// a b - c d to two units in the last place, exactly 0 where a b = c d, exactly the opposite of c d - a b.
/// Products and the difference of their rounding errors are exact (Dekker, Knuth); after Kahan's formula,
/// which is not antisymmetric.
inline double difference_of_products(double a, double b, double c, double d) {
  const double ab = a * b, cd = c * d;
  const double error_ab = std::fma(a, b, -ab), error_cd = std::fma(c, d, -cd);
  const double error = error_ab - error_cd;
  const double part = error - error_ab;
  const double rest = (error_ab - (error - part)) - (error_cd + part);
  return ((ab - cd) + error) + rest;
}

inline Vector3d accurate_cross(const Vector3d& a, const Vector3d& b) {
  return {difference_of_products(a[1], b[2], a[2], b[1]), difference_of_products(a[2], b[0], a[0], b[2]),
          difference_of_products(a[0], b[1], a[1], b[0])};
}

/// Maps points near a box to coordinates of size 1, multiples of 2^-50: sums and differences of four of them
/// are exact. Moves a point by at most 2^-50 of the box's largest edge [m].
class Grid {
 public:
  explicit Grid(const Aabb& bounds) : origin_(0.5 * bounds.min + 0.5 * bounds.max) {
    const double half = (bounds.max - origin_).cwiseMax(origin_ - bounds.min).maxCoeff();
    int exponent = 0;
    if (half > 0.0) std::frexp(half, &exponent);
    length_ = std::ldexp(1.0, exponent);
  }
  /// Coordinates in [-1, 1].
  Vector3d operator()(const Vector3d& point) const {
    constexpr double kShift = 0x1.8p2;  // its last bit is worth 2^-50
    const Vector3d x = (point - origin_) / length_;
    return (x.array() + kShift) - kShift;
  }
  /// What 1 stands for [m].
  double length() const { return length_; }
  Vector3d world(const Vector3d& x) const { return origin_ + length_ * x; }

 private:
  Vector3d origin_;
  double length_ = 1.0;
};

}  // namespace feder
