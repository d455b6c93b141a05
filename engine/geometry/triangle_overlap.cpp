// Triangles by separating axes (notes A12). Fast test: planes n_A, n_B, then of the nine edge pairs the two
// that bound the segments cut from the line where the planes meet (Guigue and Devillers 2003). A sign counts
// only beyond kRounding; if one does not, all axes along which the closest points of two triangles can face
// each other are tried: vertex-face n, edge-edge e x f, vertex-edge (e x d) x e, vertex-vertex d, d from a
// corner of A to one of B. The classical 2 + 9 axes are among them, and the 6 in-plane axes n x e of coplanar
// triangles are (e x d) x e. The largest gap is then the distance itself, also for segments, points and
// needles, whose 11 axes give as little as (angle x distance). Corners are moved to a grid on which
// differences are exact, cross products are accurate in every component: what is decided is exact but for a
// displacement of 2^-50.
#include "engine/geometry/triangle_overlap.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/geometry/aabb.h"
#include "engine/geometry/accurate_vectors.h"

namespace feder {
namespace {

enum class Answer { kApart, kOverlap, kUnknown };

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
// Error of (e x f) . d with e, f, d differences of corners, over the largest components E F D: 54 half
// epsilons.
constexpr double kRounding = 32.0 * kEpsilon;
// Error of a gap on the grid, in units of its length.
constexpr double kGridRounding = 16.0 * kEpsilon;
constexpr double kTiny = std::numeric_limits<double>::min();

double largest(const Vector3d& x) {
  return std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2])});
}

double dot(const Vector3d& a, const Vector3d& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// The corners of b over the plane of a: which one is alone on its side, and is that side the positive one?
struct Sides {
  Answer answer;
  int alone = 0;
  bool positive = true;
};

Sides sides_of_plane(const Triangle& a, const Triangle& b) {
  const Vector3d e = a[1] - a[0], f = a[2] - a[0], normal = e.cross(f);
  double height[3], reach = 0.0;
  for (int k = 0; k < 3; ++k) {
    const Vector3d d = b[k] - a[0];
    height[k] = dot(normal, d);
    reach = std::max(reach, largest(d));
  }
  const double rounding = kRounding * largest(e) * largest(f) * reach + kTiny;
  const auto [low, high] = std::minmax({height[0], height[1], height[2]});
  if (low > rounding || high < -rounding) return {Answer::kApart};
  for (double h : height)
    if (!(std::abs(h) > rounding)) return {Answer::kUnknown};
  const bool s0 = height[0] > 0.0, s1 = height[1] > 0.0, s2 = height[2] > 0.0;
  const int alone = s0 == s1 ? 2 : s0 == s2 ? 1 : 0;
  return {Answer::kOverlap, alone, height[alone] > 0.0};
}

// Does edge pair (p0 p1, q0 q1) keep the two segments on the common line apart?
Answer edge_pair(const Vector3d& p0, const Vector3d& p1, const Vector3d& q0, const Vector3d& q1,
                 double sign) {
  const Vector3d e = p1 - p0, f = q1 - q0, d = q0 - p0;
  const double volume = sign * dot(e.cross(f), d);
  const double rounding = kRounding * largest(e) * largest(f) * largest(d) + kTiny;
  return volume > rounding ? Answer::kApart : volume < -rounding ? Answer::kOverlap : Answer::kUnknown;
}

Answer fast_test(const Triangle& a, const Triangle& b) {
  // every corner strictly on one side of the other plane, or nothing is decided here
  const Sides of_a = sides_of_plane(b, a);
  if (of_a.answer == Answer::kApart) return Answer::kApart;
  const Sides of_b = sides_of_plane(a, b);
  if (of_b.answer == Answer::kApart) return Answer::kApart;
  if (of_a.answer == Answer::kUnknown || of_b.answer == Answer::kUnknown) return Answer::kUnknown;

  // the lone corners first, both on positive sides: turn a triangle round where the other's lone corner is
  // below it
  const int i = of_a.alone, j = of_b.alone;
  int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
  if (!of_b.positive) std::swap(i1, i2);
  if (!of_a.positive) std::swap(j1, j2);
  const Answer first = edge_pair(a[i], a[i1], b[j], b[j1], -1.0);
  const Answer second = edge_pair(a[i], a[i2], b[j], b[j2], 1.0);
  if (first == Answer::kApart || second == Answer::kApart) return Answer::kApart;
  return first == Answer::kOverlap && second == Answer::kOverlap ? Answer::kOverlap : Answer::kUnknown;
}

// Largest gap so far of two triangles on the grid.
struct Best {
  double gap = -std::numeric_limits<double>::infinity();
  Vector3d axis = Vector3d::UnitX();

  void consider(const Vector3d& v, const Triangle& a, const Triangle& b) {
    const double length = v.norm();
    if (length == 0.0) return;
    const auto [low_a, high_a] = std::minmax({dot(v, a[0]), dot(v, a[1]), dot(v, a[2])});
    const auto [low_b, high_b] = std::minmax({dot(v, b[0]), dot(v, b[1]), dot(v, b[2])});
    const bool forward = low_b - high_a >= low_a - high_b;
    const double along = (forward ? low_b - high_a : low_a - high_b) / length;
    if (along <= gap) return;
    gap = along;
    axis = (forward ? 1.0 : -1.0) / length * v;
  }
};

// Stops at the first gap above `enough`.
Best best_axis(const Triangle& a, const Triangle& b, double enough) {
  Vector3d e[3], f[3];
  for (int i = 0; i < 3; ++i) {
    e[i] = a[(i + 1) % 3] - a[i];
    f[i] = b[(i + 1) % 3] - b[i];
  }
  Best best;
  // vertex-face, edge-edge
  best.consider(accurate_cross(e[0], e[1]), a, b);
  best.consider(accurate_cross(f[0], f[1]), a, b);
  if (best.gap > enough) return best;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      best.consider(accurate_cross(e[i], f[j]), a, b);
      if (best.gap > enough) return best;
    }
  // vertex-vertex, vertex-edge
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const Vector3d d = b[j] - a[i];
      best.consider(d, a, b);
      best.consider(accurate_cross(accurate_cross(e[i], d), e[i]), a, b);
      best.consider(accurate_cross(accurate_cross(f[j], d), f[j]), a, b);
      if (best.gap > enough) return best;
    }
  return best;
}

Best best_axis_on_grid(const Grid& grid, const Triangle& a, const Triangle& b, double enough) {
  return best_axis({grid(a[0]), grid(a[1]), grid(a[2])}, {grid(b[0]), grid(b[1]), grid(b[2])}, enough);
}

Grid grid_around(const Triangle& a, const Triangle& b) {
  return Grid(merged(fit_aabb(a), fit_aabb(b)));
}

}  // namespace

TriangleSeparation separation(const Triangle& a, const Triangle& b) {
  const Grid grid = grid_around(a, b);
  const Best best = best_axis_on_grid(grid, a, b, std::numeric_limits<double>::infinity());
  if (std::isinf(best.gap)) return {};
  return {best.gap <= kGridRounding, grid.length() * best.gap, best.axis};
}

bool overlap(const Triangle& a, const Triangle& b) {
  const Answer answer = fast_test(a, b);
  if (answer != Answer::kUnknown) return answer == Answer::kOverlap;
  return best_axis_on_grid(grid_around(a, b), a, b, kGridRounding).gap <= kGridRounding;
}

}  // namespace feder
