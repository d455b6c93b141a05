#pragma once

#include <vector>

namespace feder {

/// One mode of a chain and its amplitude [m]. Numbers count from 1; negative ones from the end, -1 is the
/// highest.
struct Mode {
  int number = 1;
  double amplitude = 0.0;
};

/// Number of the mode from 1 to n; throws InputError if the chain of n nodes has none.
int mode_index(const char* place, const Mode& mode, int n);

/// Shape sin(i j pi / (n + 1)) of mode j at node i of n nodes between two fixed ends; nodes count from 1.
double mode_shape(int n, int j, int i);

/// Frequency 2 sqrt(stiffness / mass) sin(j pi / (2 (n + 1))) [rad/s] of mode j: n masses [kg] between fixed
/// ends, tied by springs [N/m]. Beads on a taut string have stiffness = tension / link length.
double mode_frequency(int n, int j, double stiffness, double mass);

}  // namespace feder
