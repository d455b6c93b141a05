// Newton's rule (notes D2, D3):  p_n = -(1 + e) u_n / W_nn.
// The naive rule (notes D5): u' = (-e u_n, 0), if |p_t| <= mu p_n; else p = p_n (1, -mu s/|s|) with the slip
// s before the impact, and u_n' = -e u_n. It may gain energy: Kane and Levinson 1985, Stronge 1990. Painleve
// 1895: a sliding contact pushes itself together if W_nn - mu W_nt.s/|s| < 0.
#include "solvers/contact/impact_law.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/check.h"
#include "solvers/contact/impact_path.h"

namespace feder {
namespace {

using Eigen::Vector2d;

constexpr double kSymmetric = 1e-12;  // of tr W

void check(const Matrix3d& W, const Vector3d& u, double friction, double restitution) {
  FEDER_CHECK(W.allFinite() && u.allFinite(), "W and u must be finite");
  const double small = kSymmetric * W.trace();
  FEDER_CHECK(W(0, 0) > 0.0 && (W - W.transpose()).cwiseAbs().maxCoeff() <= small, "W: symmetric, W_nn > 0");
  // Principal minors of a matrix scaled by its trace.
  const auto minor = [&](int i, int j) { return W(i, i) * W(j, j) - W(i, j) * W(j, i); };
  FEDER_CHECK(W(1, 1) >= -small && W(2, 2) >= -small, "W must be positive semidefinite");
  FEDER_CHECK(std::min({minor(0, 1), minor(0, 2), minor(1, 2)}) >= -small * W.trace() &&
                  W.determinant() >= -small * W.trace() * W.trace(),
              "W must be positive semidefinite");
  FEDER_CHECK(friction >= 0.0, "friction must be in [0, infinity]");
  FEDER_CHECK(restitution >= 0.0 && restitution <= 1.0, "restitution must be in [0, 1]");
}

ImpactResult untouched(const Vector3d& u) {
  ImpactResult out;
  out.velocity = u;
  return out;
}

// Velocity and energy from the impulse.
void complete(ImpactResult& out, const Matrix3d& W, const Vector3d& u) {
  out.velocity = u + W * out.impulse;
  out.energy_change = 0.5 * out.impulse.dot(u + out.velocity);
}

// An impulse given at once: works as if it had grown along a straight line.
ImpactResult at_once(const Matrix3d& W, const Vector3d& u, const Vector3d& impulse, double restitution) {
  ImpactResult out;
  out.impulse = impulse;
  complete(out, W, u);
  out.compression_work = 0.5 * impulse[0] * u[0] / (1.0 + restitution);
  out.restitution_work = -restitution * restitution * out.compression_work;
  out.friction_work = 0.5 * impulse.tail<2>().dot((u + out.velocity).tail<2>());
  out.slip = Slip::kThroughout;
  return out;
}

ImpactResult without_friction(const Matrix3d& W, const Vector3d& u, double restitution) {
  return at_once(W, u, {-(1.0 + restitution) * u[0] / W(0, 0), 0.0, 0.0}, restitution);
}

// The impulse of Newton's rule that leaves no slip, or p_n < 0 if there is none.
Vector3d sticking_impulse(const Matrix3d& W, const Vector3d& u, double restitution) {
  const Eigen::FullPivLU<Matrix3d> factor(W);
  const Vector3d change(-(1.0 + restitution) * u[0], -u[1], -u[2]), impulse = factor.solve(change);
  const bool solved = (W * impulse - change).norm() <= kSymmetric * change.norm();
  return solved ? impulse : Vector3d(-1.0, 0.0, 0.0);
}

ImpactResult naive(const Matrix3d& W, const Vector3d& u, double friction, double restitution) {
  const Vector3d stuck = sticking_impulse(W, u, restitution);
  const double needed = stuck.tail<2>().norm();
  if (stuck[0] >= 0.0 && (std::isinf(friction) || needed <= friction * stuck[0])) {
    ImpactResult out = at_once(W, u, stuck, restitution);
    out.slip = Slip::kStopped;
    return out;
  }
  // Against the first slip; without one, along the impulse that would have held.
  const Vector2d slip = u.tail<2>().norm() > 0.0 ? u.tail<2>() : Vector2d(-stuck.tail<2>());
  const bool slides = std::isfinite(friction) && !slip.isZero(0.0);
  const double margin = slides ? painleve_margin(W, friction, slip) : 0.0;
  ImpactResult out = untouched(u);
  out.jammed = margin < 0.0;
  out.status = StatusCode::kRefused;
  if (margin <= 0.0) return out;
  Vector3d impulse;
  impulse << 1.0, -friction * slip.normalized();
  return at_once(W, u, impulse * (-(1.0 + restitution) * u[0] / margin), restitution);
}

// Scaled by powers of two, which round nothing, to a size near 1.
ImpactResult along_path(const Matrix3d& W, const Vector3d& u, double friction, double restitution,
                        ImpactRule rule) {
  const double speed = std::exp2(std::ilogb(u.cwiseAbs().maxCoeff()));
  const double inertia = std::exp2(std::ilogb(W.trace()));
  ImpactResult out = follow_impact_path(W / inertia, u / speed, friction, restitution, rule);
  out.impulse *= speed / inertia;
  for (double* work : {&out.compression_work, &out.restitution_work, &out.friction_work})
    *work *= speed * (speed / inertia);
  complete(out, W, u);
  return out;
}

}  // namespace

ImpactResult resolve_impact(const Matrix3d& W, const Vector3d& u, double friction, double restitution,
                            ImpactRule rule) {
  check(W, u, friction, restitution);
  FEDER_CHECK(rule != ImpactRule::kNewton || friction == 0.0, "Newton's rule has no friction");
  if (!(u[0] < 0.0)) return untouched(u);
  if (friction == 0.0) return without_friction(W, u, restitution);
  if (rule == ImpactRule::kNaive) return naive(W, u, friction, restitution);
  return along_path(W, u, friction, restitution, rule);
}

ImpactResult resolve_tangential_impact(const Matrix3d& W, const Vector3d& u, double friction,
                                       double restitution) {
  check(W, u, friction, restitution);
  FEDER_CHECK(u[0] == 0.0, "a tangential impact starts from u_n = 0");
  const Vector2d slip = u.tail<2>();
  if (slip.isZero(0.0)) return untouched(u);
  const double margin =
      std::isinf(friction) ? -W.bottomLeftCorner<2, 1>().dot(slip) : painleve_margin(W, friction, slip);
  return margin < 0.0 ? along_path(W, u, friction, restitution, ImpactRule::kStronge) : untouched(u);
}

double painleve_margin(const Matrix3d& W, double friction, const Vector2d& slip) {
  FEDER_CHECK(std::isfinite(friction), "friction must be finite");
  FEDER_CHECK(slip.allFinite() && !slip.isZero(0.0), "a direction of slip is needed");
  return W(0, 0) - friction * W.bottomLeftCorner<2, 1>().dot(slip.stableNormalized());
}

double critical_friction(const Matrix3d& W) {
  FEDER_CHECK(W.allFinite() && W(0, 0) > 0.0, "W must be finite, W_nn > 0");
  const double coupling = W.bottomLeftCorner<2, 1>().norm();
  return coupling > 0.0 ? W(0, 0) / coupling : std::numeric_limits<double>::infinity();
}

}  // namespace feder
