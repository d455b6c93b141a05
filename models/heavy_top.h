#pragma once

#include <cmath>

#include "models/model.h"

namespace feder {

enum class TopStart { kReleased, kSteady };

/// A solid cylinder that spins on a point of its axis under gravity: it precesses and nutates.
struct HeavyTop {
  double mass = 1.0;                   ///< [kg]
  double radius = 0.1, height = 0.04;  ///< of the cylinder [m]
  double distance = 0.12;              ///< of its centre from the support [m]
  double spin = 150.0;                 ///< angular velocity about its own axis [rad/s]
  double tilt = 0.8;                   ///< of its axis from upright [rad]
  double precession = 0.0;             ///< of its axis about the vertical at the start [rad/s]
  TopStart start = TopStart::kReleased;
  double stiffness = INFINITY;  ///< of the support [N/m]; infinite: a hard ball joint
  double gravity = 9.81;        ///< along -y [m/s^2]
};

/// The slower precession at which the tilt stays as it is [rad/s]; InputError where the spin is too slow.
double steady_precession(const HeavyTop& options);
Model make_heavy_top(const HeavyTop& options = {});
ModelInfo heavy_top_model();

}  // namespace feder
