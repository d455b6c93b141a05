#pragma once

#include "models/fluid_scene.h"

namespace feder {

enum class BathShape { kSphere, kTorus, kBox };

/// A closed triangle mesh falls into a square tank, in space. Lengths of the tank count in spacings. The
/// floor stops the fluid only: above density 1 the end time is that of a free fall to the floor.
struct Bath : FluidChoice {
  Bath() { support = 2.5; }
  double spacing = 0.08;                 ///< [m]
  int columns = 14;                      ///< of the tank, both ways
  int layers = 7;                        ///< of the fluid
  BathShape shape = BathShape::kSphere;  ///< of the mesh
  double radius = 0.25;                  ///< half of the mesh's width [m]
  double density = 0.4;                  ///< of the solid over that of the fluid
  double height = 0.1;                   ///< of its lowest point over the fluid at the start [m]
  double spin = 0.0;                     ///< about x at the start [rad/s]
};

Model make_bath(const Bath& options = {});
ModelInfo bath_model();

}  // namespace feder
