#pragma once

#include "models/model.h"

namespace feder {

/// A crank-rocker whose coupler is a chain of short bars on soft welds, held by a spring from its middle to
/// the ground: hard hinges beside soft rows.
struct FlexibleLinkage {
  double ground = 1.0, crank = 0.4, coupler = 0.9, rocker = 0.8;  ///< lengths between hinges [m]
  int segments = 6;                                               ///< bars of the coupler
  double density = 1.0;                                           ///< of the bars [kg/m]
  double width = 0.04;                                            ///< of the square sections [m]
  double stiffness = 1e5;                                         ///< of the welds against parting [N/m]
  double angular_stiffness = 100.0;                               ///< of the welds against bending [N m]
  double damping_time = 1e-3;                                     ///< of the welds [s]
  double spring = 50.0;                                           ///< stiffness of the spring [N/m]
  double angle = 1.0, speed = 8.0;                                ///< of the crank [rad, rad/s]
  double tilt = 0.5;                                              ///< of its plane, as in FourBar [rad]
  double gravity = 9.81;                                          ///< along -y [m/s^2]
};

Model make_flexible_linkage(const FlexibleLinkage& options = {});
ModelInfo flexible_linkage_model();

}  // namespace feder
