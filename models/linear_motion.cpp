// With C and S the solutions of y'' = (decay^2 - omega^2) y that start at (1, 0) and (0, 1):
//   x = e^(-decay t) (x0 C + (v0 + decay x0) S),   v = e^(-decay t) (v0 C - (decay v0 + omega^2 x0) S)
// cos and sin below the critical damping, cosh and sinh above; both S tend to t at the critical one.
#include "models/linear_motion.h"

#include <cmath>

namespace feder {

LinearMotion linear_motion(double omega, double decay, const LinearMotion& start, double t) {
  // C and S with the factor e^(-decay t)
  double C, S;
  const double gap = (omega - decay) * (omega + decay);
  if (gap >= 0.0) {
    const double envelope = std::exp(-decay * t), rate = std::sqrt(gap);
    C = envelope * std::cos(rate * t);
    S = envelope * (rate > 0.0 ? std::sin(rate * t) / rate : t);
  } else {
    // slow root rate - decay = -omega^2 / (rate + decay), free of cancellation
    const double rate = std::sqrt(-gap);
    const double slow = std::exp(-omega * omega / (rate + decay) * t);
    C = 0.5 * slow * (1.0 + std::exp(-2.0 * rate * t));
    S = -0.5 * slow * std::expm1(-2.0 * rate * t) / rate;
  }
  return {start.x * C + (start.v + decay * start.x) * S,
          start.v * C - (decay * start.v + omega * omega * start.x) * S};
}

}  // namespace feder
