// With rho_n = 1/W_nn, rho_t = 2/tr(W_tt) of each contact's own 3 x 3 block and z = y - rho u, the law holds
// iff
//   y_n = max(0, z_n),   y_t = z_t cut to length mu y_n                           (Alart and Curnier 1991)
// Newton, by the branch z is in:
//   open   y = 0                stick  u = 0                slide  u_n = 0, y_t = mu y_n d, d = z_t/|z_t|:
//   dy_t - mu d dy_n - (mu y_n/|z_t|) (E - d d^T) (dy_t - rho_t du_t) = mu y_n d - y_t
// Redundant contacts make W singular. Newton's matrix (not the law) has a share (kShifts) of W's diagonal
// added: the part of y that W does not see stays where it is, the rest converges by that factor per
// iteration.
#include "solvers/contact/contact_problem.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <vector>

namespace feder {
namespace {

// The smallest first; where targets of redundant contacts do not agree, larger ones keep the branches apart.
constexpr double kShifts[] = {1e-8, 1e-4, 1e-2, 1e-6};
// Rounding of W y against itself: no violation can be told below it.
constexpr double kRounding = 1e-15;
// What cutting into the cones may add to a violation at the bound.
constexpr double kCut = 10.0;
// Sweeps between two attempts of Newton.
constexpr int kRound = 50;

using Vector2d = Eigen::Vector2d;

struct Steps {
  double normal, tangent;
};

Steps steps(const ContactProblem& p, int i) {
  const double n = p.W(3 * i, 3 * i), t = 0.5 * (p.W(3 * i + 1, 3 * i + 1) + p.W(3 * i + 2, 3 * i + 2));
  return {n > 0.0 ? 1.0 / n : 1.0, t > 0.0 ? 1.0 / t : 1.0};
}

Vector2d cut(const Vector2d& z, double length) {
  const double size = z.norm();
  return size > length ? Vector2d(z * (length / size)) : z;
}

// Violation of one contact, as a velocity.
double violation(const ContactProblem& p, int i, const Vector3d& y, const Vector3d& u) {
  const Steps rho = steps(p, i);
  const double normal = y[0] - std::max(0.0, y[0] - rho.normal * u[0]);
  const Vector2d tangent =
      y.tail<2>() - cut(y.tail<2>() - rho.tangent * u.tail<2>(), p.friction[i] * std::max(0.0, y[0]));
  return std::max(std::abs(normal) / rho.normal, tangent.norm() / rho.tangent);
}

double violation(const ContactProblem& p, const VectorXd& y, const VectorXd& u) {
  double worst = 0.0;
  for (int i = 0; i < p.count(); ++i) {
    const double here = violation(p, i, y.segment<3>(3 * i), u.segment<3>(3 * i));
    if (std::isnan(here)) return here;
    worst = std::max(worst, here);
  }
  return worst;
}

double bound(const ContactProblem& p, const ContactOptions& options, const VectorXd& y) {
  const double b = p.b.size() ? p.b.lpNorm<Eigen::Infinity>() : 0.0;
  double rounding = 0.0;
  for (int i = 0; i < y.size(); ++i) rounding = std::max(rounding, p.W(i, i) * std::abs(y[i]));
  return std::max(
      {options.tolerance * b, options.floor, kRounding * static_cast<double>(y.size()) * rounding});
}

void sweep(const ContactProblem& p, VectorXd& y, VectorXd& u) {
  for (int i = 0; i < p.count(); ++i) {
    const Steps rho = steps(p, i);
    const Vector3d before = y.segment<3>(3 * i);
    Vector3d now = before, ui = u.segment<3>(3 * i);
    now[0] = std::max(0.0, now[0] - rho.normal * ui[0]);
    ui += p.W.block<3, 1>(3 * i, 3 * i) * (now[0] - before[0]);
    now.tail<2>() = cut(now.tail<2>() - rho.tangent * ui.tail<2>(), p.friction[i] * now[0]);
    if (now != before) u += p.W.middleCols<3>(3 * i) * (now - before);
    y.segment<3>(3 * i) = now;
  }
}

// One Newton step: y and u = W y + b advance. False where the matrix has no inverse.
bool newton_step(const ContactProblem& p, double shift, VectorXd& y, VectorXd& u) {
  std::vector<int> active;
  VectorXd step = VectorXd::Zero(y.size());
  for (int i = 0; i < p.count(); ++i) {
    if (y[3 * i] - steps(p, i).normal * u[3 * i] > 0.0)
      active.push_back(i);
    else
      step.segment<3>(3 * i) = -y.segment<3>(3 * i);
  }
  if (!active.empty()) {
    const int m = 3 * static_cast<int>(active.size());
    // the velocities after the open contacts let go
    VectorXd at = u;
    for (int i = 0; i < p.count(); ++i)
      if (!step.segment<3>(3 * i).isZero(0.0)) at += p.W.middleCols<3>(3 * i) * step.segment<3>(3 * i);
    Eigen::MatrixXd matrix(m, m);
    VectorXd rhs(m);
    for (int a = 0; a < m; a += 3) {
      const int i = active[a / 3];
      for (int c = 0; c < m; c += 3) matrix.block<3, 3>(a, c) = p.W.block<3, 3>(3 * i, 3 * active[c / 3]);
      for (int k = 0; k < 3; ++k) matrix(a + k, a + k) += shift * p.W(3 * i + k, 3 * i + k);
      rhs.segment<3>(a) = -at.segment<3>(3 * i);
      const Steps rho = steps(p, i);
      const double length = p.friction[i] * std::max(0.0, y[3 * i]);
      const Vector2d yt = y.segment<2>(3 * i + 1), z = yt - rho.tangent * u.segment<2>(3 * i + 1);
      const double size = z.norm();
      if (size <= length && p.friction[i] > 0.0) continue;  // stick: u = 0
      const Vector2d d = size > 0.0 ? Vector2d(z / size) : Vector2d::Zero();
      const Eigen::Matrix2d turn =
          (size > 0.0 ? length / size : 0.0) * (Eigen::Matrix2d::Identity() - d * d.transpose());
      // dy_t - mu d dy_n - turn (dy_t - rho du_t) = mu y_n d - y_t, with du = W dy
      const Eigen::Matrix<double, 2, Eigen::Dynamic> W = matrix.middleRows<2>(a + 1);
      rhs.segment<2>(a + 1) = length * d - yt - turn * (rho.tangent * (at - u).segment<2>(3 * i + 1));
      matrix.middleRows<2>(a + 1) = rho.tangent * turn * W;
      matrix.block<2, 2>(a + 1, a + 1) += Eigen::Matrix2d::Identity() - turn;
      matrix.block<2, 1>(a + 1, a) -= p.friction[i] * d;
    }
    const VectorXd solution = matrix.partialPivLu().solve(rhs);
    if (!solution.allFinite()) return false;
    for (int a = 0; a < m; a += 3) step.segment<3>(3 * active[a / 3]) = solution.segment<3>(a);
  }
  y += step;
  u = p.W * y + p.b;
  return true;
}

Status left_open(const ContactProblem& p, const ContactReport& report) {
  char text[200];
  (void)std::snprintf(
      text, sizeof text,
      "the contact law of %d contacts is left open by %.2e m/s (velocities up to %.2e m/s) after "
      "%d Newton iterations and %d sweeps",
      p.count(), report.violation, p.b.lpNorm<Eigen::Infinity>(), report.newton_iterations, report.sweeps);
  return Status::failure(std::isfinite(report.violation) ? StatusCode::kNotConverged : StatusCode::kNonFinite,
                         text);
}

// Into the cones exactly, what the tolerance may have left outside; then the verdict.
ContactReport finish(const ContactProblem& p, const ContactOptions& options, VectorXd& y,
                     ContactReport report) {
  for (int i = 0; i < p.count(); ++i) {
    y[3 * i] = std::max(0.0, y[3 * i]);
    y.segment<2>(3 * i + 1) = cut(y.segment<2>(3 * i + 1), p.friction[i] * y[3 * i]);
  }
  report.violation = contact_violation(p, y);
  if (!(report.violation <= kCut * bound(p, options, y))) report.status = left_open(p, report);
  return report;
}

}  // namespace

double contact_violation(const ContactProblem& p, const VectorXd& y) {
  return violation(p, y, p.W * y + p.b);
}

ContactReport solve_by_sweeps(const ContactProblem& p, const ContactOptions& options, VectorXd& y) {
  ContactReport report;
  y.conservativeResize(p.b.size());
  VectorXd u = p.W * y + p.b;
  while (report.sweeps < options.most_sweeps && violation(p, y, u) > bound(p, options, y)) {
    sweep(p, y, u);
    ++report.sweeps;
  }
  return finish(p, options, y, report);
}

ContactReport solve_contacts(const ContactProblem& p, const ContactOptions& options, VectorXd& y) {
  ContactReport report;
  if (p.count() == 0) return report;
  if (!p.W.allFinite() || !p.b.allFinite()) {
    report.status = Status::failure(StatusCode::kNonFinite, "a contact row is not finite");
    return report;
  }
  VectorXd u = p.W * y + p.b;
  double reached = violation(p, y, u);
  auto good = [&] { return reached <= bound(p, options, y); };
  for (int round = 0; !good() && report.sweeps < options.most_sweeps; ++round) {
    const double shift = kShifts[round % std::size(kShifts)];
    VectorXd trial = y, velocity = u;
    double best = reached;
    for (int k = 0; k < options.most_newton && !good(); ++k) {
      if (!newton_step(p, shift, trial, velocity)) break;
      ++report.newton_iterations;
      const double now = violation(p, trial, velocity);
      if (now < reached) {
        y = trial, u = velocity;
        reached = now;
      }
      if (k >= 8 && !(reached < 0.5 * best)) break;  // it wanders
    }
    if (good()) break;
    for (int k = 0; k < kRound && report.sweeps < options.most_sweeps; ++k, ++report.sweeps) sweep(p, y, u);
    u = p.W * y + p.b;
    reached = violation(p, y, u);
  }
  return finish(p, options, y, report);
}

}  // namespace feder
