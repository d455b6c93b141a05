#pragma once

#include <Eigen/Core>
#include <array>

#include "engine/state.h"

namespace feder {

/// Sliding friction as a flow: dp = (normal, -tangential slip/|slip|) |slip| d tau, du = W dp. The factors
/// are cosine and sine of the angle of friction, so that friction may be infinite (normal = 0).
struct SlipFlow {
  SlipFlow(const Matrix3d& W, double friction);

  /// d u_n / d tau for this slip, also per unit of speed if slip has length one.
  double approach(const Eigen::Vector2d& slip, double speed) const {
    return normal * W(0, 0) * speed - tangential * coupling.dot(slip);
  }
  /// d slip / d tau.
  Eigen::Vector2d rate(const Eigen::Vector2d& slip, double speed) const {
    return normal * speed * coupling - tangential * (inertia * slip);
  }

  Matrix3d W;
  double normal, tangential;
  Eigen::Vector2d coupling;  ///< W_tn
  Eigen::Matrix2d inertia;   ///< W_tt, an inverse mass
  double largest_rate;       ///< bound of |rate| / speed
};

/// Taylor series in tau of the flow and of its integrals, all 0 at tau = 0 but slip, speed and velocity.
class SlipSeries {
 public:
  static constexpr int kOrder = 20;
  using Series = std::array<double, kOrder + 1>;

  SlipSeries(const SlipFlow& flow, const Vector3d& u);

  /// Length of the step on which the series holds to rounding, relative to the speed.
  double step() const { return step_; }

  Eigen::Vector2d slip(double tau) const { return {sum(slip_[0], tau), sum(slip_[1], tau)}; }
  double speed(double tau) const { return sum(speed_, tau); }
  double normal_velocity(double tau) const { return sum(normal_velocity_, tau); }
  double length(double tau) const { return integral(speed_, tau); }       ///< of speed
  double normal_work(double tau) const { return integral(power_, tau); }  ///< of u_n speed
  double friction(double tau) const { return integral(square_, tau); }    ///< of speed^2
  Eigen::Vector2d path(double tau) const {                                ///< of slip
    return {integral(slip_[0], tau), integral(slip_[1], tau)};
  }

 private:
  static double sum(const Series& a, double tau);
  static double integral(const Series& a, double tau);

  Series slip_[2]{}, speed_{}, square_{}, normal_velocity_{}, power_{};
  double step_;
};

}  // namespace feder
