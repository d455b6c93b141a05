// Random bodies in contact, and rods that strike the ground.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "engine/mass_properties.h"
#include "solvers/contact/body_contact.h"
#include "tests/support/random.h"

namespace feder::test {

struct BodyPair {
  ContactBody a, b;
  BodyVelocity velocity_a, velocity_b;
  Matrix3d axes, W;
  Vector3d u;
};

inline Matrix3d random_rotation(Random& random) {
  return Eigen::Quaterniond(Eigen::Vector4d(random.numbers(4))).normalized().toRotationMatrix();
}

/// A box with edges between 10^-spread and 10^spread, touched at a corner, on an edge or on a face.
inline ContactBody random_box(Random& random, double spread) {
  const Vector3d edges = random.vector(spread).unaryExpr([](double x) { return std::pow(10.0, x); });
  const MassProperties box = solid_box("box", std::pow(10.0, random.uniform()), edges);
  const Matrix3d turn = random_rotation(random);
  Vector3d point;
  for (int i = 0; i < 3; ++i)
    point[i] = 0.5 * edges[i] * (random.below(2) ? random.uniform() : random.below(2) ? 1.0 : -1.0);
  return {1.0 / box.mass, turn * box.inertia.inverse() * turn.transpose(), turn * point};
}

/// Two boxes, or a box on the stationary world, approaching; half of them hardly slipping.
inline BodyPair random_pair(Random& random, double spread = 1.0) {
  BodyPair out;
  if (random.below(2)) out.a = random_box(random, spread);
  out.b = random_box(random, spread);
  if (out.a.inverse_mass > 0.0) out.velocity_a = {random.vector(), random.vector(3.0)};
  out.velocity_b = {random.vector(), random.vector(3.0)};
  out.axes = contact_axes(random.vector().normalized());
  if (contact_velocity(out.a, out.velocity_a, out.b, out.velocity_b, out.axes)[0] > 0.0)
    out.axes = contact_axes(-out.axes.col(0));
  if (random.below(2)) {
    Vector3d change = -contact_velocity(out.a, out.velocity_a, out.b, out.velocity_b, out.axes);
    change[0] = 0.0;
    out.velocity_b.linear += (1.0 - std::pow(10.0, random.uniform(-3.0, 0.0))) * (out.axes * change);
  }
  out.W = contact_inverse_mass(out.a, out.b, out.axes);
  out.u = contact_velocity(out.a, out.velocity_a, out.b, out.velocity_b, out.axes);
  return out;
}

/// From 0 to infinity, both included, most of them between 0.01 and 100.
inline double random_friction(Random& random) {
  const int kind = random.below(12);
  if (kind < 2) return kind == 0 ? 0.0 : std::numeric_limits<double>::infinity();
  return kind < 6 ? random.uniform(0.0, 1.5) : std::pow(10.0, random.uniform(-2.0, 2.0));
}

inline double random_restitution(Random& random) {
  const int kind = random.below(6);
  return kind < 2 ? kind : random.uniform(0.0, 1.0);
}

/// A slender rod of 1 kg and 1 m in the plane xz, `angle` above the ground it touches with one end [rad].
inline ContactBody rod_on_end(double angle) {
  ContactBody rod;
  rod.inverse_mass = 1.0;
  rod.inverse_inertia = Vector3d(0.0, 12.0, 0.0).asDiagonal();
  rod.arm = 0.5 * Vector3d(-std::cos(angle), 0.0, -std::sin(angle));
  return rod;
}

/// Normal up (z), tangents x and y.
inline Matrix3d ground_axes() {
  Matrix3d axes;
  axes << Vector3d::UnitZ(), Vector3d::UnitX(), Vector3d::UnitY();
  return axes;
}

inline double kinetic_energy(const ContactBody& body, const BodyVelocity& v) {
  if (body.inverse_mass == 0.0) return 0.0;
  return 0.5 * (v.linear.squaredNorm() / body.inverse_mass +
                v.angular.dot(body.inverse_inertia.inverse() * v.angular));
}

}  // namespace feder::test
