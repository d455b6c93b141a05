#pragma once

#include "models/model.h"

namespace feder {

enum class ClothObstacle { kSphere, kTorus };

/// A free n x n cloth in the horizontal plane falls over a fixed ball or ring (its axis upright). The nodes
/// touch the obstacle as small balls; the cloth does not touch itself.
struct ClothDrop {
  int n = 12;                                       ///< nodes along an edge
  ClothObstacle obstacle = ClothObstacle::kSphere;  ///< of size `radius`
  double radius = 0.3;                              ///< of the ball, of the ring's circle [m]
  double tube = 0.1;                                ///< radius of the ring's tube, below `radius` [m]
  double height = 0.02;                             ///< of the cloth's surface above the obstacle [m]
  double thickness = 0.01;                          ///< of the cloth [m]
  double friction = 0.3;                            ///< Coulomb's mu
  double edge = 1.0;                                ///< [m]
  double mass = 0.3;                                ///< of the whole cloth, in equal parts [kg]
  double stiffness = 300.0;                         ///< structural springs [N/m], may be infinite
  double shear_stiffness = 30.0;                    ///< both diagonals [N/m]
  double bend_stiffness = 1.0;                      ///< springs to second neighbours [N/m]
  double damping_time = 0.0;                        ///< tau [s]
  double drag = 0.0;                                ///< per node [kg/s]
  double gravity = 9.81;                            ///< along -y [m/s^2]
};

Model make_cloth_drop(const ClothDrop& options = {});
ModelInfo cloth_drop_model();

}  // namespace feder
