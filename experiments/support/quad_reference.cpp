#include "experiments/support/quad_reference.h"

#include <cmath>
#include <string>
#include <vector>

#include "solvers/linear/linear_solver.h"

namespace feder::experiments {
namespace {

__extension__ using Quad = __float128;
using QuadVector = std::vector<Quad>;

// p - M v + J^T y and r + J v + gamma y; the scenes have distance rows only.
void quad_residual(const Kkt& kkt, const QuadVector& v, const QuadVector& y, Kkt& out) {
  const System& s = *kkt.system;
  QuadVector force(v.size());
  for (std::size_t i = 0; i < v.size(); ++i) force[i] = Quad(kkt.p[i]) - Quad(kkt.mass[i]) * v[i];
  for (int k = 0; k < s.rows; ++k) {
    const int a = 3 * s.distance.a[k], b = 3 * s.distance.b[k];
    Quad row = Quad(kkt.r[k]) + Quad(kkt.gamma[k]) * y[k];
    for (int c = 0; c < 3; ++c) {
      const Quad u = kkt.u[3 * k + c];
      row += u * (v[b + c] - v[a + c]);
      force[a + c] -= u * y[k];
      force[b + c] += u * y[k];
    }
    out.r[k] = s.stiffness[k] > 0.0 ? static_cast<double>(row) : 0.0;
  }
  for (std::size_t i = 0; i < v.size(); ++i)
    out.p[i] = s.inverse_mass[i] > 0.0 ? static_cast<double>(force[i]) : 0.0;
}

// Refinement of the solution by one route until the corrections no longer shrink.
QuadReference refine_in_quad(Kkt kkt, const std::string& route) {
  constexpr int kMostRounds = 40;
  constexpr double kEnough = 1e-20;
  const System& s = *kkt.system;
  LinearSolver solver(route, {.accept_below = HUGE_VAL, .most_refinements = 0});
  if (!solver.analyze(s, false).ok() || !solver.factor(kkt).ok()) return {};
  QuadVector v(3 * static_cast<std::size_t>(s.nodes), 0), y(static_cast<std::size_t>(s.rows), 0);
  Kkt residual = kkt;
  VectorXd dv, dy;
  QuadReference reference{VectorXd::Zero(3 * s.nodes)};
  for (int round = 0; round < kMostRounds; ++round) {
    quad_residual(kkt, v, y, residual);
    if (!solver.solve(residual, dv, dy).status.ok()) return {};
    for (int i = 0; i < dv.size(); ++i) v[static_cast<std::size_t>(i)] += dv[i];
    for (int k = 0; k < dy.size(); ++k) y[static_cast<std::size_t>(k)] += dy[k];
    for (int i = 0; i < dv.size(); ++i) reference.v[i] = static_cast<double>(v[static_cast<std::size_t>(i)]);
    const double correction = mass_norm(s, dv) / mass_norm(s, reference.v);
    if (round > 1 && !(correction < 0.9 * reference.error)) break;
    reference.error = correction;
    if (correction < kEnough) break;
  }
  return reference;
}

}  // namespace

double mass_norm(const System& s, const VectorXd& v) {
  return std::sqrt(s.inertia.cwiseProduct(v).dot(v));
}

QuadReference quad_reference(const Kkt& kkt) {
  QuadReference best;
  for (const char* route : {"kkt", "dual"}) {
    QuadReference candidate = refine_in_quad(kkt, route);
    if (!(best.error <= candidate.error)) best = std::move(candidate);
    if (best.error < 1e-16) break;
  }
  return best;
}

}  // namespace feder::experiments
