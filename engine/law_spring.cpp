// d = x_b - x_a, l = |d|, u = d/l, D = dd/dq:  f = -T(l, u.D v) D^T u,
//   K = T_l (D^T u)(D^T u)^T + T (D^T (E - u u^T)/l D + Hess(u.d)),   C = T_l' (D^T u)(D^T u)^T
// The change of u.D v with q is left out of K: it is not symmetric.
#include "engine/law_spring.h"

#include <cmath>

#include "engine/body.h"
#include "engine/check.h"

namespace feder {
namespace {

using RowMajor3 = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor, 3, 12>;

struct Line {
  Vector3d d;
  double length;
  VectorXd along;  // D^T u
  double rate;
};

Line line(const LawSpring& spring, const double* q, const double* v, RowMajor3& D) {
  D.resize(3, 3 * spring.count());
  Line out{spring.difference(q, D.data()), 0.0, {}, 0.0};
  out.length = out.d.norm();
  out.along = D.transpose() * (out.d / out.length);
  for (int c = 0; c < out.along.size(); ++c) out.rate += out.along[c] * v[3 * spring.nodes[c / 3] + c % 3];
  return out;
}

}  // namespace

void LawSpring::check(const std::string& where) const {
  AnchorPair::check(where);
  if (!law) throw InputError(where + ": law, expected a function of length and rate");
}

double LawSpring::length(const double* q) const {
  return difference(q, nullptr).norm();
}

bool LawSpring::add_force(const double* q, const double* v, double* f) const {
  RowMajor3 D;
  const Line at = line(*this, q, v, D);
  const double tension = law(at.length, at.rate).force;
  if (!(at.length > 0.0) || !std::isfinite(tension) || !std::isfinite(at.length)) return false;
  for (int c = 0; c < at.along.size(); ++c) f[3 * nodes[c / 3] + c % 3] -= tension * at.along[c];
  return true;
}

void LawSpring::stiffness(const double* q, const double* v, double sigma, double rho,
                          Eigen::Ref<Eigen::MatrixXd> out) const {
  out.setZero();
  RowMajor3 D;
  const Line at = line(*this, q, v, D);
  if (!(at.length > 0.0)) return;
  const Tension t = law(at.length, at.rate);
  const Vector3d u = at.d / at.length;
  out = t.force / at.length * D.transpose() * (Matrix3d::Identity() - u * u.transpose()) * D;
  add_curvature(q, t.force * u, out);
  out = sigma * (out + t.by_length * at.along * at.along.transpose()) +
        rho * t.by_rate * at.along * at.along.transpose();
}

}  // namespace feder
