#pragma once

#include "models/fluid_scene.h"

namespace feder {

/// A box in a tank, in the plane. Afloat it lies `density` times its height deep (Archimedes); above 1 it
/// sinks, until the end of the time it needs at least to the floor, which does not stop it. Lengths count in
/// spacings.
struct FloatingBody : FluidChoice {
  double spacing = 0.05;  ///< [m]
  int columns = 48;       ///< of the tank
  int layers = 20;        ///< of the fluid
  int wide = 12;          ///< the box
  int high = 12;          ///< the box
  double density = 0.5;   ///< of the box over that of the fluid
  double lift = 0.0;      ///< of the box over Archimedes' depth at the start [m]
};

/// How deep the bottom of an upright box lies below the level the volume of the fluid gives it at rest [m].
double draft(const FloatingBody& options, const System& system, const State& state);

Model make_floating_body(const FloatingBody& options = {});
ModelInfo floating_body_model();

}  // namespace feder
