// m x'' = -d (x + tau x') - c x', x the elongation: x'' + 2 delta x' + omega^2 x = 0, delta = (d tau + c) /
// (2 m) (notes E6: c brakes the motion itself, d tau only the change of length).
#include "models/damped_oscillator.h"

#include <cmath>
#include <numbers>

#include "engine/check.h"
#include "models/linear_motion.h"
#include "models/parameters.h"

namespace feder {
namespace {

using D = DampedOscillator;

const Fields<D>& fields() {
  static const Fields<D> list = {
      field("mass", &D::mass, "kg", "the mass", kPositive),
      field("stiffness", &D::stiffness, "N/m", "d of the spring", kPositive),
      field("damping_time", &D::damping_time, "s", "row damping tau", kNonNegative),
      field("drag", &D::drag, "kg/s", "linear drag c of the mass", kNonNegative),
      field("length", &D::length, "m", "rest length of the spring", kPositive),
      field("amplitude", &D::amplitude, "m", "initial elongation", kAnyNumber),
      field("velocity", &D::velocity, "m/s", "initial velocity along the spring", kAnyNumber),
  };
  return list;
}

}  // namespace

double decay_rate(const DampedOscillator& o) {
  return (o.stiffness * o.damping_time + o.drag) / (2.0 * o.mass);
}

Model make_damped_oscillator(const DampedOscillator& o) {
  check_fields("model damped_oscillator", fields(), o);
  // the energy never rises, so neither does this bound on |x|
  const double omega = std::sqrt(o.stiffness / o.mass), reach = std::hypot(o.amplitude, o.velocity / omega);
  if (!(reach < o.length))
    fail_input("model damped_oscillator", "largest elongation of amplitude and velocity", reach, "m",
               "less than the rest length " + to_text(o.length));

  SystemBuilder builder;
  const Anchor wall = builder.add_world_point(Vector3d::Zero());
  const Anchor mass =
      builder.add_particle(o.mass, {o.length + o.amplitude, 0.0, 0.0}, {o.velocity, 0.0, 0.0});
  builder.add_distance(wall, mass, {o.stiffness, o.damping_time}, o.length);
  builder.set_drag(o.drag);
  auto [system, state] = builder.build();

  Model model{"damped_oscillator", std::move(system), state};
  model.end_time = 2.0 * 2.0 * std::numbers::pi / omega;
  model.scene_length = o.length;
  model.exact = [o, omega, state = state](double t) {
    const LinearMotion motion = linear_motion(omega, decay_rate(o), {o.amplitude, o.velocity}, t);
    State s = state;
    s.t = t;
    s.q[3] = o.length + motion.x;
    s.v[3] = motion.v;
    return s;
  };
  if (decay_rate(o) == 0.0) model.conserved = {conserved_energy()};
  return model;
}

ModelInfo damped_oscillator_model() {
  return describe("damped_oscillator", "the oscillator with row damping and linear drag; exact", fields(),
                  make_damped_oscillator);
}

}  // namespace feder
