#pragma once

#include "models/model.h"

namespace feder {

/// Scenes S4(n) and, 100 times stiffer, S4s(n): a cube of n^3 nodes tied to their 26 neighbours, pinned at x
/// = 0, sagging from rest.
struct Lattice {
  int n = 10;                 ///< nodes along an edge
  double edge = 1.0;          ///< [m]
  double mass = 1.0;          ///< of the whole cube, in equal parts [kg]
  double stiffness = 200.0;   ///< a spring has stiffness / (n - 1) [N/m]
  double gravity = 9.81;      ///< along -y [m/s^2]
  double damping_time = 0.0;  ///< tau [s]
  double drag = 0.0;          ///< per node [kg/s]
};

/// Springs of the lattice: 3 n^2 (n-1) along edges, 6 n (n-1)^2 and 4 (n-1)^3 along diagonals.
double lattice_springs(int n);

Model make_lattice(const Lattice& options = {});
ModelInfo lattice_model();

}  // namespace feder
