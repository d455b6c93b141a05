#pragma once

#include "models/model.h"

namespace feder {

/// Scene S2(n): a square n x n net in the xz plane, pinned at its two corners x = 0, falling from rest.
struct Cloth {
  int n = 20;                    ///< nodes along an edge
  double edge = 1.0;             ///< [m]
  double mass = 1.0;             ///< of the whole cloth, in equal parts [kg]
  double stiffness = 1e5;        ///< structural springs [N/m], may be infinite
  double shear_stiffness = 1e5;  ///< both diagonals [N/m]
  double bend_stiffness = 1e4;   ///< springs to second neighbours [N/m]
  double gravity = 9.81;         ///< along -y [m/s^2]
  double damping_time = 0.0;     ///< tau [s]
  double drag = 0.0;             ///< per node [kg/s]
};

/// The nodes and springs of a cloth whose first corner is at `corner`, on `builder`; drag and gravity too.
/// Returns its first node.
int add_cloth(SystemBuilder& builder, const Cloth& options, const Vector3d& corner, bool pinned);

/// Springs of the cloth: 2 n (n-1) structural, 2 (n-1)^2 shear, 2 n (n-2) bend.
double cloth_springs(int n);

Model make_cloth(const Cloth& options = {});
ModelInfo cloth_model();

}  // namespace feder
