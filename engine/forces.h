#pragma once

#include <functional>
#include <vector>

#include "engine/state.h"

namespace feder {

/// A force supplied by the user, f(t, q, v) [N], 3 per node, added into `force`.
///
/// `stiffness`, if given, writes for each stencil the symmetric matrix -df/dq [N/m] over its nodes (3k x 3k,
/// row-major, one after the other); the implicit integrators with geometric stiffness and the reference use
/// it. `potential`, if given, lets the energies include it.
struct UserForce {
  std::function<void(double t, const VectorXd& q, const VectorXd& v, VectorXd& force)> force;
  std::function<void(double t, const VectorXd& q, const VectorXd& v, double* stiffness)> stiffness;
  std::function<double(double t, const VectorXd& q)> potential;
  std::vector<std::vector<int>> stencils;  ///< nodes of each stencil of `stiffness`

  explicit operator bool() const { return static_cast<bool>(force); }
};

/// Everything that acts without a row. Constant forces and gravity are summed once when the system is built.
struct Forces {
  Vector3d gravity = Vector3d::Zero();  ///< [m/s^2]
  VectorXd constant;                    ///< gravity and constant forces, 3 per node [N], 0 where masked
  VectorXd drag;                        ///< linear drag coefficient, 3 per node [kg/s], force -drag * v
  bool has_drag = false;
  bool has_torques = false;  ///< some Body::torque
  UserForce user;
};

}  // namespace feder
