// Along:  n_a.(x_b - x_a) = (R_a n).e - n.s_a with e = x_b - c_a: only a's turn and the place of x_b enter.
//   d = R_a n . de + xi_a.(n x R_a^T e),   mixed second derivative xi_a.([n]x R_a^T dx_b)
// Turn:   psi = atan2(S, C), C = c_a . m_b, S = s_a . m_b with s_a = n x c_a, rho^2 = S^2 + C^2,
//   dpsi = (C dS - S dC)/rho^2,
//   Hess psi = (C Hess S - S Hess C)/rho^2 + [2 S C (dC dC^T - dS dS^T) + (S^2 - C^2)(dS dC^T + dC
//   dS^T)]/rho^4
#include "engine/axis_rows.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "engine/body.h"
#include "engine/check.h"

namespace feder {

void TargetPair::resolve(const std::vector<Body>& bodies) {
  AnchorPair::resolve(bodies);
  if (dial.node >= 0) nodes[AnchorPair::count()] = dial.node;
}

void TargetPair::check(const std::string& where) const {
  AnchorPair::check(where);
  require_finite(where, "rest", rest, "m or rad");
}

void TargetPair::set_dial_column(double* jacobian) const {
  if (dial.node < 0) return;
  double* J = jacobian + 3 * AnchorPair::count();
  J[0] = -1.0, J[1] = J[2] = 0.0;
}

void AlongRow::resolve(const std::vector<Body>& bodies) {
  TargetPair::resolve(bodies);
  principal_axis = in_principal_axes(a, axis, bodies);
}

void AlongRow::check(const std::string& where) const {
  TargetPair::check(where);
  check_direction(where, "axis", axis);
}

bool AlongRow::evaluate(const double* q, double* phi, double* jacobian) const {
  const Matrix3d Ra = rotation(at_a, q), Rb = rotation(at_b, q);
  const Eigen::Map<const Vector3d> ca(q + 3 * at_a.node), cb(q + 3 * at_b.node);
  const Vector3d n = Ra * principal_axis, e = cb + Rb * at_b.point - ca;
  *phi = n.dot(e - Ra * at_a.point) - target(q);
  if (!jacobian) return true;
  Eigen::Map<VectorXd> J(jacobian, 3 * count());
  J.segment<3>(0) = -n;
  if (at_a.spin >= 0) J.segment<3>(3) = principal_axis.cross(Ra.transpose() * e);
  const int of_b = 3 * at_a.count();
  J.segment<3>(of_b) = n;
  if (at_b.spin >= 0) J.segment<3>(of_b + 3) = at_b.point.cross(Rb.transpose() * n);
  set_dial_column(jacobian);
  return true;
}

void AlongRow::hessian(const double* q, const double* lambda, Eigen::Ref<Eigen::MatrixXd> out) const {
  out.setZero();
  const Matrix3d Ra = rotation(at_a, q), Rb = rotation(at_b, q);
  const Eigen::Map<const Vector3d> ca(q + 3 * at_a.node), cb(q + 3 * at_b.node);
  const Vector3d e = cb + Rb * at_b.point - ca;
  const int of_b = 3 * at_a.count();
  if (at_b.spin >= 0) out.block<3, 3>(of_b + 3, of_b + 3) = turned_twice(Rb, at_b.point, Ra * principal_axis);
  if (at_a.spin >= 0) {
    out.block<3, 3>(3, 3) = turned_twice(Ra, principal_axis, e);
    const Matrix3d mixed = skew(principal_axis) * Ra.transpose();
    auto set = [&](int column, const Matrix3d& block) {
      out.block<3, 3>(3, column) = block;
      out.block<3, 3>(column, 3) = block.transpose();
    };
    set(0, -mixed);
    set(of_b, mixed);
    if (at_b.spin >= 0) set(of_b + 3, -mixed * Rb * skew(at_b.point));
  }
  out *= *lambda;
}

void TurnRow::resolve(const std::vector<Body>& bodies) {
  TargetPair::resolve(bodies);
  cosine_a = in_principal_axes(a, direction_a, bodies);
  sine_a = in_principal_axes(a, axis.cross(direction_a), bodies);
  principal_b = in_principal_axes(b, direction_b, bodies);
}

void TurnRow::check(const std::string& where) const {
  TargetPair::check(where);
  check_direction(where, "axis", axis);
  check_direction(where, "direction a", direction_a);
  check_direction(where, "direction b", direction_b);
  if (!(std::abs(axis.dot(direction_a)) <= 1e-9))
    fail_input(where, "axis . direction a", axis.dot(direction_a), "", "0: perpendicular directions");
}

double TurnRow::angle(const double* q) const {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  const double raw = std::atan2(dot(q, sine_a, principal_b, nullptr), dot(q, cosine_a, principal_b, nullptr));
  return raw + kTurn * std::round((q[3 * dial.node + 1] - raw) / kTurn);
}

bool TurnRow::evaluate(const double* q, double* phi, double* jacobian) const {
  *phi = angle(q) - target(q);
  using Gradient = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3 * kNodes, 1>;
  Gradient dS(3 * AnchorPair::count()), dC(dS.size());
  const double S = dot(q, sine_a, principal_b, dS.data()), C = dot(q, cosine_a, principal_b, dC.data());
  const double squared = S * S + C * C;
  const bool sound = squared > 0.0 && std::isfinite(squared);
  if (!sound) *phi = 0.0;
  if (!jacobian) return sound;
  Eigen::Map<Gradient> J(jacobian, dS.size());
  if (sound)
    J = (C * dS - S * dC) / squared;
  else
    J.setZero();
  set_dial_column(jacobian);
  return sound;
}

void TurnRow::hessian(const double* q, const double* lambda, Eigen::Ref<Eigen::MatrixXd> out) const {
  out.setZero();
  const int size = 3 * AnchorPair::count();
  VectorXd dS(size), dC(size);
  const double S = dot(q, sine_a, principal_b, dS.data()), C = dot(q, cosine_a, principal_b, dC.data());
  const double squared = S * S + C * C;
  if (!(squared > 0.0)) return;
  add_dot_curvature(q, sine_a, principal_b, *lambda * C / squared, out);
  add_dot_curvature(q, cosine_a, principal_b, -*lambda * S / squared, out);
  const double fourth = *lambda / (squared * squared);
  auto corner = out.topLeftCorner(size, size);
  corner += 2.0 * S * C * fourth * (dC * dC.transpose() - dS * dS.transpose());
  corner += (S * S - C * C) * fourth * (dS * dC.transpose() + dC * dS.transpose());
}

}  // namespace feder
