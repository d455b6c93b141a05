#pragma once

#include "models/fluid_scene.h"

namespace feder {

/// A block of fluid behind a dam that is gone at t = 0, on a dry floor (Ritter 1892: in shallow water the
/// front moves with 2 sqrt(g height)). In the plane, or with `slices` layers between two more walls.
struct DamBreak : FluidChoice {
  int layers = 20;      ///< of particles in the height
  int slices = 0;       ///< of particles across; 0: in the plane
  double height = 0.5;  ///< of the fluid [m]
  double width = 1.0;   ///< of the fluid [m]
  double length = 3.0;  ///< of the tank [m]
};

/// Largest x of a particle that has others within `reach` [m]; a lone drop is no front.
double front(const System& system, const State& state, double reach);

Model make_dam_break(const DamBreak& options = {});
ModelInfo dam_break_model();

}  // namespace feder
