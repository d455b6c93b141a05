// Rows between anchors (notes E15). A point s of a body is x = c + R s; with R -> R exp([xi]x),
//   dx = -R [s]x xi,   d2(f.x) = xi.(1/2 (g s^T + s g^T) - (g.s) E) xi,   g = R^T f
//   distance:       J = u^T dd, Hess = dd^T (E - u u^T)/l dd + Hess(u.d),   u = d/l
//   perpendicular:  d(n_a.n_b) = xi_a.(n x R_a^T m) + xi_b.(m x R_b^T n), n, m the directions in body axes;
//                   mixed second derivative [n]x^T R_a^T R_b [m]x
#include "engine/anchor_rows.h"

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "engine/body.h"
#include "engine/check.h"

namespace feder {

Matrix3d rotation(const Place& place, const double* q) {
  return place.spin < 0 ? Matrix3d(Matrix3d::Identity()) : rotation_matrix(q + place.quaternion);
}

Matrix3d turned_twice(const Matrix3d& R, const Vector3d& s, const Vector3d& f) {
  const Vector3d g = R.transpose() * f;
  return 0.5 * (g * s.transpose() + s * g.transpose()) - g.dot(s) * Matrix3d::Identity();
}

namespace {

using RowMajor3 = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor, 3, 12>;

Place resolved(const Anchor& anchor, const std::vector<Body>& bodies) {
  if (anchor.body < 0) return {anchor.node};
  const Body& b = bodies[anchor.body];
  return {b.centre, b.spin, b.quaternion, b.axes.transpose() * (anchor.point - b.centre_point)};
}

}  // namespace

void check_direction(const std::string& where, const char* name, const Vector3d& n) {
  if (!(std::abs(n.norm() - 1.0) <= 1e-9)) fail_input(where, name, n.norm(), "", "a direction of length 1");
}

Vector3d in_principal_axes(const Anchor& anchor, const Vector3d& n, const std::vector<Body>& bodies) {
  return anchor.body < 0 ? n : Vector3d(bodies[anchor.body].axes.transpose() * n);
}

void AnchorPair::resolve(const std::vector<Body>& bodies) {
  at_a = resolved(a, bodies);
  at_b = resolved(b, bodies);
  int i = 0;
  for (const Place* place : {&at_a, &at_b}) {
    nodes[i++] = place->node;
    if (place->spin >= 0) nodes[i++] = place->spin;
  }
}

void AnchorPair::check(const std::string& where) const {
  for (const Anchor* anchor : {&a, &b})
    for (int c = 0; c < 3; ++c) require_finite(where, "point", anchor->point[c], "m");
}

Vector3d AnchorPair::difference(const double* q, double* jacobian) const {
  Vector3d d = Vector3d::Zero();
  int column = 0;
  const int stride = 3 * count();
  for (const auto& [place, sign] : {std::pair{&at_a, -1.0}, std::pair{&at_b, 1.0}}) {
    const Matrix3d R = rotation(*place, q);
    d += sign * (Eigen::Map<const Vector3d>(q + 3 * place->node) + R * place->point);
    if (!jacobian) continue;
    Eigen::Map<RowMajor3> J(jacobian, 3, stride);
    J.middleCols<3>(column) = sign * Matrix3d::Identity();
    column += 3;
    if (place->spin < 0) continue;
    J.middleCols<3>(column) = -sign * R * skew(place->point);
    column += 3;
  }
  return d;
}

void AnchorPair::add_curvature(const double* q, const Vector3d& f, Eigen::Ref<Eigen::MatrixXd> out) const {
  int block = 0;
  for (const auto& [place, sign] : {std::pair{&at_a, -1.0}, std::pair{&at_b, 1.0}}) {
    if (place->spin >= 0)
      out.block<3, 3>(3 * block + 3, 3 * block + 3) +=
          turned_twice(rotation(*place, q), place->point, sign * f);
    block += place->count();
  }
}

bool BallRow::evaluate(const double* q, double* phi, double* jacobian) const {
  Eigen::Map<Vector3d>{phi} = difference(q, jacobian);
  return true;
}

void BallRow::hessian(const double* q, const double* lambda, Eigen::Ref<Eigen::MatrixXd> out) const {
  out.setZero();
  add_curvature(q, Eigen::Map<const Vector3d>(lambda), out);
}

void AnchorDistanceRow::check(const std::string& where) const {
  AnchorPair::check(where);
  require_positive(where, "rest length", rest, "m");
}

bool AnchorDistanceRow::evaluate(const double* q, double* phi, double* jacobian) const {
  RowMajor3 D(3, 3 * count());
  const Vector3d d = difference(q, jacobian ? D.data() : nullptr);
  const double length = d.norm();
  const bool sound = length > 0.0 && std::isfinite(length);
  *phi = sound ? length - rest : 0.0;
  if (jacobian) {
    Eigen::Map<Eigen::RowVectorXd> J(jacobian, 3 * count());
    if (sound)
      J = (d / length).transpose() * D;
    else
      J.setZero();
  }
  return sound;
}

void AnchorDistanceRow::hessian(const double* q, const double* lambda,
                                Eigen::Ref<Eigen::MatrixXd> out) const {
  out.setZero();
  RowMajor3 D(3, 3 * count());
  const Vector3d d = difference(q, D.data());
  const double length = d.norm();
  if (!(length > 0.0)) return;
  const Vector3d u = d / length;
  out = *lambda / length * D.transpose() * (Matrix3d::Identity() - u * u.transpose()) * D;
  add_curvature(q, *lambda * u, out);
}

double AnchorPair::dot(const double* q, const Vector3d& n, const Vector3d& m, double* gradient) const {
  const Matrix3d Ra = rotation(at_a, q), Rb = rotation(at_b, q);
  const Vector3d n_world = Ra * n, m_world = Rb * m;
  if (gradient) {
    Eigen::Map<VectorXd> J(gradient, 3 * count());
    J.setZero();
    if (at_a.spin >= 0) J.segment<3>(3) = n.cross(Ra.transpose() * m_world);
    if (at_b.spin >= 0) J.segment<3>(3 * at_a.count() + 3) = m.cross(Rb.transpose() * n_world);
  }
  return n_world.dot(m_world);
}

void AnchorPair::add_dot_curvature(const double* q, const Vector3d& n, const Vector3d& m, double weight,
                                   Eigen::Ref<Eigen::MatrixXd> out) const {
  const Matrix3d Ra = rotation(at_a, q), Rb = rotation(at_b, q);
  const int i = 3, j = 3 * at_a.count() + 3;
  if (at_a.spin >= 0) out.block<3, 3>(i, i) += weight * turned_twice(Ra, n, Rb * m);
  if (at_b.spin >= 0) out.block<3, 3>(j, j) += weight * turned_twice(Rb, m, Ra * n);
  if (at_a.spin < 0 || at_b.spin < 0) return;
  const Matrix3d mixed = weight * skew(n).transpose() * Ra.transpose() * Rb * skew(m);
  out.block<3, 3>(i, j) += mixed;
  out.block<3, 3>(j, i) += mixed.transpose();
}

void PerpendicularRow::resolve(const std::vector<Body>& bodies) {
  AnchorPair::resolve(bodies);
  principal_a = in_principal_axes(a, direction_a, bodies);
  principal_b = in_principal_axes(b, direction_b, bodies);
}

void PerpendicularRow::check(const std::string& where) const {
  AnchorPair::check(where);
  check_direction(where, "direction a", direction_a);
  check_direction(where, "direction b", direction_b);
}

bool PerpendicularRow::evaluate(const double* q, double* phi, double* jacobian) const {
  *phi = dot(q, principal_a, principal_b, jacobian);
  return true;
}

void PerpendicularRow::hessian(const double* q, const double* lambda, Eigen::Ref<Eigen::MatrixXd> out) const {
  out.setZero();
  add_dot_curvature(q, principal_a, principal_b, *lambda, out);
}

}  // namespace feder
