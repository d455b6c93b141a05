#pragma once

#include "engine/rotation.h"
#include "engine/state.h"

namespace feder {

struct System;

/// Where a body of a System sits in its vectors.
struct Body {
  int centre = -1, spin = -1;          ///< nodes
  int quaternion = -1;                 ///< offset in q
  Vector3d moments;                    ///< principal [kg m^2]
  Matrix3d axes;                       ///< columns: principal axes in the axes the body was given in
  Vector3d centre_point;               ///< centre of mass in those axes [m]
  Vector3d torque = Vector3d::Zero();  ///< constant, in world axes [N m]
};

/// World axes of the axes the body was given in.
Matrix3d orientation(const Body& body, const VectorXd& q);
/// In world axes [rad/s].
Vector3d angular_velocity(const Body& body, const State& state);
/// World place and velocity of an anchor.
Vector3d position(const System& system, const Anchor& anchor, const VectorXd& q);
Vector3d velocity(const System& system, const Anchor& anchor, const State& state);

/// out = q moved by dt v: places along v, bodies turned by dt times their spin. `out` may be q.
void advance(const System& system, double dt, const VectorXd& v, const VectorXd& q, VectorXd& out,
             RotationUpdate update = RotationUpdate::kExponential);
/// rate = dq/dt at v, quaternions included; for methods that add rates and normalise at the end.
void position_rate(const System& system, const VectorXd& q, const VectorXd& v, VectorXd& rate);
void normalise_quaternions(const System& system, VectorXd& q);
/// f += -w x I w on the spins [N m].
void add_gyroscopic_torques(const System& system, const VectorXd& v, VectorXd& f);
/// f += constant world torques in principal axes.
void add_torques(const System& system, const VectorXd& q, VectorXd& f);
/// v <- v after the implicit gyroscopic step of every spin; false if one did not converge.
bool step_gyroscopic_terms(const System& system, double dt, VectorXd& v);

}  // namespace feder
