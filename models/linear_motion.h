#pragma once

namespace feder {

/// A displacement [m] and its rate [m/s].
struct LinearMotion {
  double x = 0.0, v = 0.0;
};

/// x'' + 2 decay x' + omega^2 x = 0 from `start`, after time t [s]; omega > 0 [rad/s], decay >= 0 [1/s].
/// Under-, over- and critically damped motions pass into each other without a jump.
LinearMotion linear_motion(double omega, double decay, const LinearMotion& start, double t);

}  // namespace feder
