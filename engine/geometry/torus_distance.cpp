// Distance of two tori (notes C10) = distance of their centre circles - both tube radii.
// Circle A in its own axes: centre 0, radius r, normal z. A point x of circle B, at angle t, is
//   g(t) = |(z, q - r)|,  q = sqrt(x^2 + y^2)
// away from it; g^2 = |x|^2 + r^2 - 2 r q, and with P = |x|^2 and Q = q^2, trigonometric polynomials of
// degree 1 and 2, g' = 0 becomes P'^2 Q = r^2 Q'^2: degree 4 in t, degree 8 in e^(i t). The angles of all
// eight roots, true ones and not, and some even ones between them bracket every minimum of g; each is then
// closed in on by golden section on g itself, which keeps its accuracy where the circles meet and where roots
// coincide.
#include "engine/geometry/torus_distance.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "engine/check.h"

namespace feder {
namespace {

using std::numbers::pi;

// Of the size of a pair: touching tori overlap.
constexpr double kRounding = 1e-14;
using Complex = std::complex<double>;

// sum over |k| <= degree of coefficient[k + degree] e^(i k t)
using Series = std::vector<Complex>;

Series operator*(const Series& a, const Series& b) {
  Series out(a.size() + b.size() - 1);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) out[i + j] += a[i] * b[j];
  return out;
}

Series derivative(Series a) {
  const int degree = static_cast<int>(a.size() / 2);
  for (int k = -degree; k <= degree; ++k) a[k + degree] *= Complex(0.0, k);
  return a;
}

// c + u cos t + v sin t
Series harmonic(double c, double u, double v) {
  return {{0.5 * u, 0.5 * v}, c, {0.5 * u, -0.5 * v}};
}

// Angles of all roots of a real series; of none where it vanishes.
void append_root_angles(Series s, std::vector<double>& angles) {
  double largest = 0.0;
  for (const Complex& c : s) largest = std::max(largest, std::abs(c));
  while (s.size() > 1 && std::abs(s.back()) <= 1e-15 * largest) s = Series(s.begin() + 1, s.end() - 1);
  const int degree = static_cast<int>(s.size()) - 1;
  if (degree < 1) return;

  // companion matrix
  Eigen::MatrixXcd C = Eigen::MatrixXcd::Zero(degree, degree);
  for (int k = 0; k < degree; ++k) {
    C(k, degree - 1) = -s[k] / s[degree];
    if (k > 0) C(k, k - 1) = 1.0;
  }
  const Eigen::ComplexEigenSolver<Eigen::MatrixXcd> solver(C, false);
  for (const Complex& root : solver.eigenvalues()) angles.push_back(std::arg(root));
}

// Circle B seen from circle A, lengths in units of the pair's size.
struct Pair {
  double radius;                  // of A
  Vector3d centre, cosine, sine;  // B: centre + cosine cos t + sine sin t

  Vector3d at(double t) const { return centre + std::cos(t) * cosine + std::sin(t) * sine; }
  double distance(double t) const {
    const Vector3d x = at(t);
    return std::hypot(x[2], std::hypot(x[0], x[1]) - radius);
  }
  // P'^2 Q - r^2 Q'^2
  Series critical() const {
    const Vector3d c = centre, u = cosine, v = sine;
    const Series x = harmonic(c[0], u[0], v[0]), y = harmonic(c[1], u[1], v[1]);
    const Series xx = x * x, yy = y * y;
    Series Q(5);
    for (int k = 0; k < 5; ++k) Q[k] = xx[k] + yy[k];
    const Series dP = derivative(harmonic(0.0, 2.0 * c.dot(u), 2.0 * c.dot(v))), dQ = derivative(Q);
    Series out = dP * dP * Q;
    const Series other = dQ * dQ;
    for (std::size_t k = 0; k < out.size(); ++k) out[k] -= radius * radius * other[k];
    return out;
  }
};

// Golden section between low and high.
double minimum_between(const Pair& pair, double low, double high) {
  constexpr double kGolden = 0.3819660112501051;
  double s = low + kGolden * (high - low), t = high - kGolden * (high - low);
  double at_s = pair.distance(s), at_t = pair.distance(t);
  while (low < s && s < t && t < high) {
    if (at_s <= at_t) {
      high = t, t = s, at_t = at_s;
      s = low + kGolden * (high - low);
      at_s = pair.distance(s);
    } else {
      low = s, s = t, at_s = at_t;
      t = high - kGolden * (high - low);
      at_t = pair.distance(t);
    }
  }
  return at_s <= at_t ? s : t;
}

double closest_angle(const Pair& pair) {
  constexpr int kEven = 64;
  std::vector<double> angle;
  for (int k = 0; k < kEven; ++k) angle.push_back(pi * (2.0 * k / kEven - 1.0));
  append_root_angles(pair.critical(), angle);
  std::sort(angle.begin(), angle.end());

  const int count = static_cast<int>(angle.size());
  std::vector<double> value;
  for (double t : angle) value.push_back(pair.distance(t));
  double best = angle[std::min_element(value.begin(), value.end()) - value.begin()];
  for (int k = 0; k < count; ++k) {
    const int before = (k + count - 1) % count, after = (k + 1) % count;
    if (value[k] > value[before] || value[k] > value[after]) continue;
    const double low = angle[before] - (k == 0 ? 2.0 * pi : 0.0),
                 high = angle[after] + (after == 0 ? 2.0 * pi : 0.0);
    const double t = minimum_between(pair, low, high);
    if (pair.distance(t) < pair.distance(best)) best = t;
  }
  return best;
}

void check(const Circle& circle) {
  FEDER_CHECK(circle.centre.allFinite() && circle.normal.allFinite() && std::isfinite(circle.radius),
              "a circle is not finite");
  FEDER_CHECK(circle.radius >= 0.0 && circle.normal.norm() > 0.0,
              "a circle has a radius < 0 or a normal of 0");
}

// Columns: a rotation whose last axis is the normal.
Matrix3d axes_of(const Circle& circle) {
  const Vector3d z = circle.normal.normalized(), x = z.unitOrthogonal();
  Matrix3d out;
  out << x, z.cross(x), z;
  return out;
}

// Walks along b.
CircleDistance distance_along(const Circle& a, const Circle& b, double size) {
  const Matrix3d A = axes_of(a), B = axes_of(b);
  const Matrix3d local = A.transpose() * B * (b.radius / size);
  const Pair pair{a.radius / size, A.transpose() * (b.centre - a.centre) / size, local.col(0), local.col(1)};

  // the closest point of A lies below that of B; on A's axis any point does
  const double t = closest_angle(pair);
  const Vector3d x = pair.at(t);
  const double q = std::hypot(x[0], x[1]);
  const Vector3d below = q > 0.0 ? Vector3d(x[0] / q, x[1] / q, 0.0) : Vector3d::UnitX();
  return {size * pair.distance(t), a.centre + a.radius * (A * below), a.centre + size * (A * x)};
}

}  // namespace

CircleDistance distance(const Circle& a, const Circle& b) {
  check(a);
  check(b);
  const double size = (b.centre - a.centre).norm() + (a.radius + b.radius);
  if (size == 0.0) return {0.0, a.centre, b.centre};

  // along either circle: where all but one is rounding, as with circles that nearly coincide, one may err
  const CircleDistance along_b = distance_along(a, b, size), along_a = distance_along(b, a, size);
  if (along_b.distance <= along_a.distance) return along_b;
  return {along_a.distance, along_a.point_b, along_a.point_a};
}

double gap(const Torus& a, const Torus& b) {
  FEDER_CHECK(a.minor >= 0.0 && b.minor >= 0.0, "a torus has a tube radius < 0");
  return distance(a.circle, b.circle).distance - (a.minor + b.minor);
}

bool overlap(const Torus& a, const Torus& b) {
  const double size = (b.circle.centre - a.circle.centre).norm() + a.circle.radius + b.circle.radius;
  return gap(a, b) <= kRounding * (size + a.minor + b.minor);
}

}  // namespace feder
