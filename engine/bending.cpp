// Bending rows over x0, x1, x2 with a = x1 - x0, b = x2 - x1 (notes E2).
//
// Curvature: for a weight w, s = w.kappa = n / D with n = 2 w.(a x b), D = |a||b| + a.b. First and second
// derivatives of n and D are elementary (below); s follows from the quotient rule. Row i is w = e_i. Angle:
// psi = atan2(|c|, a.b), c = a x b, e = c/|c|:  grad_a psi = a x e / a^2,  grad_b psi = e x b / b^2.
#include "engine/bending.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "engine/check.h"

namespace feder {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Matrix9d = Eigen::Matrix<double, 9, 9>;

// |a x b| below this fraction of |a||b| counts as straight or folded: the angle is lost to rounding there.
constexpr double kDegenerateSine = 1e-12;

struct Edges {
  Vector3d a, b;
  double length_a, length_b;
};

Edges edges(const std::array<int, 3>& nodes, const double* q) {
  const Eigen::Map<const Vector3d> x0(q + 3 * nodes[0]), x1(q + 3 * nodes[1]), x2(q + 3 * nodes[2]);
  Edges e{x1 - x0, x2 - x1, 0.0, 0.0};
  e.length_a = e.a.norm();
  e.length_b = e.b.norm();
  return e;
}

Matrix3d skew(const Vector3d& w) {
  Matrix3d m;
  m << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
  return m;
}

// Derivatives by (a, b) become derivatives by (x0, x1, x2): a = x1 - x0, b = x2 - x1.
void gradient_to_nodes(const Vector3d& by_a, const Vector3d& by_b, double* row) {
  Eigen::Map<Vector3d>(row + 0) = -by_a;
  Eigen::Map<Vector3d>(row + 3) = by_a - by_b;
  Eigen::Map<Vector3d>(row + 6) = by_b;
}

void hessian_to_nodes(const Matrix6d& h, Eigen::Ref<Eigen::MatrixXd> out) {
  const Matrix3d aa = h.topLeftCorner<3, 3>(), ab = h.topRightCorner<3, 3>(), ba = h.bottomLeftCorner<3, 3>(),
                 bb = h.bottomRightCorner<3, 3>();
  out.block<3, 3>(0, 0) = aa;
  out.block<3, 3>(0, 3) = ab - aa;
  out.block<3, 3>(0, 6) = -ab;
  out.block<3, 3>(3, 0) = ba - aa;
  out.block<3, 3>(3, 3) = aa - ab - ba + bb;
  out.block<3, 3>(3, 6) = ab - bb;
  out.block<3, 3>(6, 0) = -ba;
  out.block<3, 3>(6, 3) = ba - bb;
  out.block<3, 3>(6, 6) = bb;
}

}  // namespace

void CurvatureRow::check(const std::string&) const {}

void AngleRow::check(const std::string& where) const {
  if (!(rest_angle > 0.0 && rest_angle < std::numbers::pi))
    fail_input(where, "rest angle", rest_angle, "rad",
               "a value inside (0, pi); a straight rest state is a curvature row");
}

bool CurvatureRow::evaluate(const double* q, double* phi, double* jacobian) const {
  const Edges e = edges(nodes, q);
  const double D = e.length_a * e.length_b + e.a.dot(e.b);
  Eigen::Map<Vector3d> kappa(phi);
  if (!(D > kDegenerateSine * e.length_a * e.length_b)) {
    kappa.setZero();
    if (jacobian) Eigen::Map<Eigen::Matrix<double, 27, 1>>(jacobian).setZero();
    return false;
  }
  kappa = 2.0 / D * e.a.cross(e.b);
  if (!jacobian) return true;

  // d kappa_i = (2 e_i.d(a x b) - kappa_i dD) / D
  const Vector3d D_a = e.length_b / e.length_a * e.a + e.b;
  const Vector3d D_b = e.length_a / e.length_b * e.b + e.a;
  for (int i = 0; i < 3; ++i) {
    const Vector3d w = Vector3d::Unit(i);
    gradient_to_nodes((2.0 * e.b.cross(w) - kappa[i] * D_a) / D, (2.0 * w.cross(e.a) - kappa[i] * D_b) / D,
                      jacobian + 9 * i);
  }
  return true;
}

void CurvatureRow::hessian(const double* q, const double* lambda, Eigen::Ref<Eigen::MatrixXd> out) const {
  const Edges e = edges(nodes, q);
  const double D = e.length_a * e.length_b + e.a.dot(e.b);
  if (!(D > kDegenerateSine * e.length_a * e.length_b)) {
    out.setZero();
    return;
  }
  const Vector3d w(lambda[0], lambda[1], lambda[2]);
  const Vector3d ua = e.a / e.length_a, ub = e.b / e.length_b;
  const Matrix3d E = Matrix3d::Identity();
  const double n = 2.0 * w.dot(e.a.cross(e.b));

  // first derivatives of n and D, then second ones
  Vector6d n_x, D_x;
  n_x << 2.0 * e.b.cross(w), 2.0 * w.cross(e.a);
  D_x << e.length_b * ua + e.b, e.length_a * ub + e.a;
  Matrix6d n_xx = Matrix6d::Zero(), D_xx;
  n_xx.topRightCorner<3, 3>() = -2.0 * skew(w);
  n_xx.bottomLeftCorner<3, 3>() = 2.0 * skew(w);
  D_xx << e.length_b / e.length_a * (E - ua * ua.transpose()), ua * ub.transpose() + E,
      ub * ua.transpose() + E, e.length_a / e.length_b * (E - ub * ub.transpose());

  // quotient rule for s = n / D
  const Matrix6d s_xx = n_xx / D - (n_x * D_x.transpose() + D_x * n_x.transpose()) / (D * D) -
                        n / (D * D) * D_xx + 2.0 * n / (D * D * D) * D_x * D_x.transpose();
  hessian_to_nodes(s_xx, out);
}

bool AngleRow::evaluate(const double* q, double* phi, double* jacobian) const {
  const Edges e = edges(nodes, q);
  const Vector3d c = e.a.cross(e.b);
  const double sine = c.norm();
  phi[0] = std::atan2(sine, e.a.dot(e.b)) - rest_angle;
  if (!(sine > kDegenerateSine * e.length_a * e.length_b)) {
    if (jacobian) Eigen::Map<Eigen::Matrix<double, 9, 1>>(jacobian).setZero();
    return false;
  }
  if (jacobian) {
    const Vector3d axis = c / sine;
    gradient_to_nodes(e.a.cross(axis) / e.a.squaredNorm(), axis.cross(e.b) / e.b.squaredNorm(), jacobian);
  }
  return true;
}

void AngleRow::hessian(const double* q, const double* lambda, Eigen::Ref<Eigen::MatrixXd> out) const {
  const Edges e = edges(nodes, q);
  const Vector3d c = e.a.cross(e.b);
  const double sine = c.norm(), a2 = e.a.squaredNorm(), b2 = e.b.squaredNorm();
  if (!(sine > kDegenerateSine * e.length_a * e.length_b)) {
    out.setZero();
    return;
  }
  const Vector3d axis = c / sine;
  const Matrix3d P = (Matrix3d::Identity() - axis * axis.transpose()) / sine;  // d axis = P d c
  const Vector3d g_a = e.a.cross(axis) / a2, g_b = axis.cross(e.b) / b2;

  // d c = -[b]x da + [a]x db; differentiate g_a = a x axis / a^2 and g_b = axis x b / b^2
  Matrix6d h;
  h.topLeftCorner<3, 3>() = (-skew(axis) - skew(e.a) * P * skew(e.b)) / a2 - 2.0 / a2 * g_a * e.a.transpose();
  h.topRightCorner<3, 3>() = skew(e.a) * P * skew(e.a) / a2;
  h.bottomLeftCorner<3, 3>() = h.topRightCorner<3, 3>().transpose();
  h.bottomRightCorner<3, 3>() =
      (skew(axis) - skew(e.b) * P * skew(e.a)) / b2 - 2.0 / b2 * g_b * e.b.transpose();
  h *= lambda[0];
  hessian_to_nodes(h, out);
}

}  // namespace feder
