#pragma once

#include "models/model.h"

namespace feder {

enum class FourBarBranch { kOpen, kCrossed };

/// A closed loop of hinges about parallel axes: 3 of its 20 rows depend on the others. The default is a
/// crank-rocker. crank = rocker and coupler = ground is a parallelogram, which folds flat at the crank angles
/// 0 and pi: there it may go on as either branch.
struct FourBar {
  double ground = 1.0, crank = 0.4, coupler = 0.9, rocker = 0.8;  ///< lengths between hinges [m]
  double density = 1.0;                                           ///< of the bars [kg/m]
  double width = 0.04;                                            ///< of the square sections [m]
  double angle = 1.0, speed = 8.0;                                ///< of the crank [rad, rad/s]
  FourBarBranch branch = FourBarBranch::kOpen;
  double tilt = 0.5;      ///< of its plane out of xy, about (1, 2, 2) [rad]
  double gravity = 9.81;  ///< along -y [m/s^2]
};

Model make_four_bar(const FourBar& options = {});
ModelInfo four_bar_model();

}  // namespace feder
