// Rigid bodies as two nodes: the centre moves like a particle, the spin v is the angular velocity w in
// principal axes:
//   R' = R [w]x,   I w' = R^T T - w x I w,   a point s of the body: x = c + R s, x' = c' - R [s]x w
// In these axes the mass matrix is constant and diagonal. World angular velocity is R w; turning by exp(dt w)
// leaves it where it is, so a step that keeps w keeps the world's, too.
#include "engine/body.h"

#include <Eigen/Geometry>

#include "engine/system.h"

namespace feder {

Matrix3d orientation(const Body& b, const VectorXd& q) {
  return rotation_matrix(q.data() + b.quaternion) * b.axes.transpose();
}

Vector3d angular_velocity(const Body& b, const State& state) {
  return rotation_matrix(state.q.data() + b.quaternion) * state.v.segment<3>(3 * b.spin);
}

namespace {
// the anchor's point in principal axes about the centre
Vector3d arm(const Body& b, const Anchor& anchor) {
  return b.axes.transpose() * (anchor.point - b.centre_point);
}
}  // namespace

Vector3d position(const System& s, const Anchor& anchor, const VectorXd& q) {
  if (anchor.body < 0) return q.segment<3>(3 * anchor.node);
  const Body& b = s.bodies[anchor.body];
  return q.segment<3>(3 * b.centre) + rotation_matrix(q.data() + b.quaternion) * arm(b, anchor);
}

Vector3d velocity(const System& s, const Anchor& anchor, const State& state) {
  if (anchor.body < 0) return state.v.segment<3>(3 * anchor.node);
  const Body& b = s.bodies[anchor.body];
  const Vector3d w = state.v.segment<3>(3 * b.spin);
  return state.v.segment<3>(3 * b.centre) +
         rotation_matrix(state.q.data() + b.quaternion) * w.cross(arm(b, anchor));
}

void advance(const System& s, double dt, const VectorXd& v, const VectorXd& q, VectorXd& out,
             RotationUpdate update) {
  out.resize(q.size());
  kernels().drift(3 * s.places(), dt, v.data(), q.data(), out.data());
  for (const Body& b : s.bodies) {
    out.segment<4>(b.quaternion) = q.segment<4>(b.quaternion);
    turn(dt * v.segment<3>(3 * b.spin), update, out.data() + b.quaternion);
  }
}

void position_rate(const System& s, const VectorXd& q, const VectorXd& v, VectorXd& rate) {
  rate.resize(q.size());
  rate.head(3 * s.places()) = v.head(3 * s.places());
  for (const Body& b : s.bodies)
    quaternion_rate(q.data() + b.quaternion, v.segment<3>(3 * b.spin), rate.data() + b.quaternion);
}

void normalise_quaternions(const System& s, VectorXd& q) {
  for (const Body& b : s.bodies) normalise(q.data() + b.quaternion);
}

void add_gyroscopic_torques(const System& s, const VectorXd& v, VectorXd& f) {
  for (const Body& b : s.bodies) {
    const Vector3d w = v.segment<3>(3 * b.spin);
    f.segment<3>(3 * b.spin) -= w.cross(b.moments.cwiseProduct(w));
  }
}

void add_torques(const System& s, const VectorXd& q, VectorXd& f) {
  for (const Body& b : s.bodies)
    if (!b.torque.isZero(0.0))
      f.segment<3>(3 * b.spin) += rotation_matrix(q.data() + b.quaternion).transpose() * b.torque;
}

bool step_gyroscopic_terms(const System& s, double dt, VectorXd& v) {
  bool finite = true;
  for (const Body& b : s.bodies) {
    if (s.free[b.spin] != kFree) continue;  // w x I w then acts about masked axes alone
    const Vector3d w = implicit_gyroscopic_step(b.moments, dt, v.segment<3>(3 * b.spin));
    finite = finite && w.allFinite();
    v.segment<3>(3 * b.spin) = w;
  }
  return finite;
}

}  // namespace feder
