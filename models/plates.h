#pragma once

#include <string>
#include <vector>

#include "models/model.h"

namespace feder {

/// What plate_bridge and plate_net share: rows of square plates side by side, at rest. Each row follows the
/// polyline `profile` in the x-y plane, one plate per piece; row j lies at z = (j + 1/2) edge. A ball joint
/// at the middle of every shared edge. The profile's pieces have length edge.
struct Plates {
  std::vector<Vector3d> profile;  ///< at z = 0 [m]
  int rows = 1;
  double edge = 0.2;            ///< in x and z [m]
  double thickness = 0.02;      ///< [m]
  double mass = 0.4;            ///< of each [kg]
  bool last_tied = true;        ///< the outer edges at the end of the profile to the world, as at its start
  double stiffness = INFINITY;  ///< of each joint [N/m]; infinite: a hard joint
  double damping_time = 0.0;    ///< tau [s]
  double gravity = 9.81;        ///< along -y [m/s^2]
};

/// Joints of such a scene, in double: check it before anything is allocated.
double plate_joints(double count_x, double count_z, bool last_tied);

Model make_plates(const std::string& name, const Plates& plates);

}  // namespace feder
