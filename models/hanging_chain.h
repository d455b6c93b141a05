#pragma once

#include "models/model.h"

namespace feder {

/// Scenes S1(N) (springs) and S1h(N) (rods): one fixed node and n masses along +x, falling from rest; turned
/// by `angle` towards -y and with a `load` at its end if asked for.
struct HangingChain {
  int n = 100;                ///< masses
  double mass = 0.01;         ///< of each node [kg]
  double stiffness = 1e6;     ///< of each link [N/m], may be infinite
  double link = 0.01;         ///< length of a link [m]
  double gravity = 9.81;      ///< along -y [m/s^2]
  double damping_time = 0.0;  ///< tau [s]
  double drag = 0.0;          ///< [kg/s]
  double load = 0.0;          ///< added to the last mass [kg]
  double angle = 0.0;         ///< below the horizontal [rad]
};

Model make_hanging_chain(const HangingChain& options = {});
ModelInfo hanging_chain_model();

}  // namespace feder
