// theta'' = -(g / length) sin theta, at rest at `angle`. With k = sin(angle / 2), k' = cos(angle / 2), u =
// omega t the solution theta = 2 asin(k sn(K - u | k)) reads, free of cancellation near theta = pi
// (Abramowitz and Stegun 16.8),
//   theta = 2 atan2(k cn u, k'),   theta' = -2 omega k k' sn u / dn u
#include "models/pendulum.h"

#include <cmath>
#include <numbers>

#include "models/elliptic.h"
#include "models/parameters.h"

namespace feder {
namespace {

const Fields<Pendulum>& fields() {
  static const Fields<Pendulum> list = {
      field("mass", &Pendulum::mass, "kg", "the mass", kPositive),
      field("length", &Pendulum::length, "m", "of the rod", kPositive),
      field("angle", &Pendulum::angle, "rad", "initial angle from hanging", {0.0, std::numbers::pi, true}),
      field("gravity", &Pendulum::gravity, "m/s^2", "along -y", kPositive),
      field("stiffness", &Pendulum::stiffness, "N/m", "of the rod", kPositiveOrRigid),
  };
  return list;
}

Modulus modulus(const Pendulum& o) {
  return {std::sin(0.5 * o.angle), std::cos(0.5 * o.angle)};
}

// q and v of the mass on the circle
State state_at(const Pendulum& o, double t) {
  const Modulus m = modulus(o);
  const double omega = std::sqrt(o.gravity / o.length);
  const JacobiElliptic e = jacobi_elliptic(omega * t, m);
  const double theta = 2.0 * std::atan2(m.k * e.cn, m.complement);
  const double speed = -2.0 * o.length * omega * m.k * m.complement * e.sn / e.dn;
  State s{t, VectorXd::Zero(6), VectorXd::Zero(6)};
  s.q.segment<2>(3) << o.length * std::sin(theta), -o.length * std::cos(theta);
  s.v.segment<2>(3) << speed * std::cos(theta), speed * std::sin(theta);
  return s;
}

}  // namespace

double pendulum_period(const Pendulum& o) {
  return 4.0 * elliptic_k(modulus(o)) / std::sqrt(o.gravity / o.length);
}

Model make_pendulum(const Pendulum& o) {
  check_fields("model pendulum", fields(), o);
  SystemBuilder builder;
  const Anchor pivot = builder.add_world_point(Vector3d::Zero());
  const Anchor mass = builder.add_particle(o.mass, state_at(o, 0.0).q.tail<3>(), Vector3d::Zero(), kPlanarXY);
  builder.add_distance(pivot, mass, {o.stiffness, 0.0}, o.length);
  builder.set_gravity({0.0, -o.gravity, 0.0});
  auto [system, state] = builder.build();

  Model model{"pendulum", std::move(system), state};
  model.end_time = 2.0 * pendulum_period(o);
  model.scene_length = o.length;
  if (std::isinf(o.stiffness)) model.exact = [o](double t) { return state_at(o, t); };
  model.conserved = {conserved_energy()};
  return model;
}

ModelInfo pendulum_model() {
  return describe("pendulum", "one mass on a rod, swinging from a large angle; exact if rigid", fields(),
                  make_pendulum);
}

}  // namespace feder
