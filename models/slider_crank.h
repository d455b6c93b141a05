#pragma once

#include "models/model.h"

namespace feder {

enum class CrankDrive { kCoasting, kMotor };

/// A crank turns a rod that pushes a slider along x: three hinges about z and a guide, 3 redundant rows.
struct SliderCrank {
  double crank = 0.2, rod = 0.5;                               ///< lengths [m], crank < rod
  double crank_mass = 1.0, rod_mass = 1.0, slider_mass = 1.0;  ///< [kg]
  double width = 0.04, slider_edge = 0.1;                      ///< sections of the bars; a cube [m]
  double angle = 1.0, speed = 10.0;                            ///< of the crank [rad, rad/s]
  CrankDrive drive = CrankDrive::kCoasting;
  double gravity = 9.81;  ///< along -y [m/s^2]
};

Model make_slider_crank(const SliderCrank& options = {});
ModelInfo slider_crank_model();

}  // namespace feder
