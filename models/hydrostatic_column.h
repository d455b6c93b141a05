#pragma once

#include "models/fluid_scene.h"

namespace feder {

/// A column of fluid between two walls in the plane, settled under its weight: p = rho g depth.
struct HydrostaticColumn : FluidChoice {
  int layers = 24;     ///< of particles
  int columns = 8;     ///< of particles
  double depth = 1.0;  ///< [m]
  double push = 0.05;  ///< initial velocity of the surface, in proportion below, downwards [m/s]
};

Model make_hydrostatic_column(const HydrostaticColumn& options = {});
ModelInfo hydrostatic_column_model();

}  // namespace feder
