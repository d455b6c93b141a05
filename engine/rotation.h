#pragma once

#include "engine/state.h"

namespace feder {

/// Rotations of rigid bodies. A unit quaternion (w, x, y, z) turns body axes into world axes, R(quaternion);
/// w below is the angular velocity in body axes [rad/s], quaternion' = 1/2 quaternion w.

/// How a step turns a body by theta = dt w (body axes).
enum class RotationUpdate {
  kExponential,      ///< quaternion exp(theta/2): the exact rotation
  kNormalisedEuler,  ///< notes B7: (quaternion + 1/2 quaternion theta), normalised: turns by 2
                     ///< atan(|theta|/2)
};

/// [a]x, so that [a]x b = a x b.
Matrix3d skew(const Vector3d& a);
Matrix3d rotation_matrix(const double* quaternion);
/// quaternion <- quaternion * step(theta), of unit length again; theta [rad] in body axes.
void turn(const Vector3d& theta, RotationUpdate update, double* quaternion);
/// J_r with exp(theta + d) = exp(theta) exp(J_r d) to first order; J_r theta = theta.
Matrix3d right_jacobian(const Vector3d& theta);
/// d(quaternion)/dt = 1/2 quaternion (0, w), into rate[4].
void quaternion_rate(const double* quaternion, const Vector3d& w, double* rate);
void normalise(double* quaternion);

/// Torque-free motion over dt of a body with principal moments I [kg m^2], second order: rotations about the
/// three axes in turn, 1 2 3 2 1. Keeps |I w| and is its own inverse under dt -> -dt, both to rounding; the
/// energy error stays bounded.
void rotate_freely(const Vector3d& moments, double dt, Vector3d& w, double* quaternion);

/// The implicit Euler step of the gyroscopic term alone, I (w* - w) + dt w* x I w* = 0: never gains energy.
/// Not finite if Newton does not converge.
Vector3d implicit_gyroscopic_step(const Vector3d& moments, double dt, const Vector3d& w);

}  // namespace feder
