#pragma once

#include "engine/system.h"

namespace feder {

/// out = Jdot v = v.(Hess phi_k) v of the hard rows [m/s^2], 0 for others; v holds the velocities of driven
/// nodes, too. With J a + phi_t's own acceleration (J times driven_accelerations) it is phi''.
void jacobian_rate(const System& system, const State& state, VectorXd& out);

}  // namespace feder
