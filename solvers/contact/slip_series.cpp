// Sliding with Coulomb friction in the time tau that removes the singularity where the slip s vanishes,
//   s' = c |s| W_tn - d W_tt s,   u_n' = c W_nn |s| - d W_nt s,   c = cos, d = sin of the angle of friction
// (Darboux 1880, Keller 1986; with |s| d tau for dp_n: Batlle 1996). Right-hand sides are homogeneous, so a
// slip dies exponentially with full relative accuracy. Taylor coefficients by recurrence, |s|^2 = s.s giving
// those of |s|; the step from the last two of them (Jorba and Zou 2005).
#include "solvers/contact/slip_series.h"

#include <algorithm>
#include <cmath>

namespace feder {
namespace {

constexpr double kTruncation = 1e-17;  // last term against the first

constexpr SlipSeries::Series kInverse = [] {
  SlipSeries::Series out{};
  for (int k = 0; k <= SlipSeries::kOrder; ++k) out[k] = 1.0 / (k + 1);
  return out;
}();

}  // namespace

SlipFlow::SlipFlow(const Matrix3d& W_, double friction)
    : W(W_),
      normal(1.0 / std::hypot(1.0, friction)),
      tangential(std::isinf(friction) ? 1.0 : friction / std::hypot(1.0, friction)),
      coupling(W_.bottomLeftCorner<2, 1>()),
      inertia(W_.bottomRightCorner<2, 2>()),
      largest_rate(normal * coupling.norm() + tangential * inertia.norm()) {}

SlipSeries::SlipSeries(const SlipFlow& flow, const Vector3d& u) {
  normal_velocity_[0] = u[0];
  slip_[0][0] = u[1];
  slip_[1][0] = u[2];
  speed_[0] = std::hypot(u[1], u[2]);
  square_[0] = speed_[0] * speed_[0];
  power_[0] = u[0] * speed_[0];
  for (int k = 0; k < kOrder; ++k) {
    // Velocities from their derivatives.
    const Eigen::Vector2d slip(slip_[0][k], slip_[1][k]), next = flow.rate(slip, speed_[k]) / (k + 1);
    slip_[0][k + 1] = next[0];
    slip_[1][k + 1] = next[1];
    normal_velocity_[k + 1] = flow.approach(slip, speed_[k]) / (k + 1);
    // |s| from |s|^2 = s.s; in the sums speed_[k + 1] is still 0.
    double square = 0.0, known = 0.0, power = 0.0;
    for (int i = 0, j = k + 1; j >= 0; ++i, --j) {
      square += slip_[0][i] * slip_[0][j] + slip_[1][i] * slip_[1][j];
      known += speed_[i] * speed_[j];
      power += normal_velocity_[i] * speed_[j];
    }
    square_[k + 1] = square;
    speed_[k + 1] = (square - known) / (2.0 * speed_[0]);
    power_[k + 1] = power + normal_velocity_[0] * speed_[k + 1];
  }
  // The speed may have singularities that a slip without coupling does not show. At most four times the
  // fastest rate, where there are no higher terms.
  step_ = 4.0 / flow.largest_rate;
  for (const int k : {kOrder - 1, kOrder}) {
    const double last = std::max({std::abs(slip_[0][k]), std::abs(slip_[1][k]), std::abs(speed_[k])});
    if (last > 0.0) step_ = std::min(step_, std::pow(kTruncation * speed_[0] / last, 1.0 / k));
  }
}

double SlipSeries::sum(const Series& a, double tau) {
  double out = 0.0;
  for (int k = kOrder; k >= 0; --k) out = out * tau + a[k];
  return out;
}

double SlipSeries::integral(const Series& a, double tau) {
  double out = 0.0;
  for (int k = kOrder; k >= 0; --k) out = out * tau + a[k] * kInverse[k];
  return out * tau;
}

}  // namespace feder
