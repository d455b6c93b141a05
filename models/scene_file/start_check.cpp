#include "models/scene_file/start_check.h"

#include <algorithm>
#include <cmath>

#include "engine/kkt.h"

namespace feder {
namespace {

constexpr double kFits = 1e-6;

}  // namespace

std::vector<Misfit> open_rows(const System& s, const State& start) {
  VectorXd phi;
  evaluate_phi(s, start.q, phi);
  const double farthest = start.q.head(3 * s.places()).cwiseAbs().maxCoeff();
  std::vector<Misfit> misfits;
  for (int k = 0; k < s.rows; ++k)
    if (std::isinf(s.stiffness[k]) && !(std::abs(phi[k]) <= kFits * std::max(1.0, farthest)))
      misfits.push_back({k, std::abs(phi[k])});
  return misfits;
}

// v holds the velocities of driven nodes and dials, so phidot = J v.
std::vector<Misfit> moving_rows(const System& s, const State& start) {
  if (!s.has_hard_rows) return {};
  Kkt kkt;
  kkt.prepare(s);
  kkt.set_step(0.0, 0.0);  // hard rows alone
  std::vector<Misfit> misfits;
  if (!kkt.evaluate(start.q, false).ok()) return misfits;
  VectorXd rate;
  kkt.multiply_jacobian(start.v, rate);
  const double fastest = start.v.size() > 0 ? start.v.cwiseAbs().maxCoeff() : 0.0;
  for (int k = 0; k < s.rows; ++k)
    if (std::isinf(s.stiffness[k]) && std::abs(rate[k]) > kFits * fastest)
      misfits.push_back({k, std::abs(rate[k])});
  return misfits;
}

}  // namespace feder
