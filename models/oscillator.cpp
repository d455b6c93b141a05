// m x'' = -d x, x the elongation of the spring: x = amplitude cos(omega t), omega^2 = d / m (notes E1, one
// mass).
#include "models/oscillator.h"

#include <cmath>
#include <numbers>

#include "engine/check.h"
#include "models/parameters.h"

namespace feder {
namespace {

const Fields<Oscillator>& fields() {
  static const Fields<Oscillator> list = {
      field("mass", &Oscillator::mass, "kg", "the mass", kPositive),
      field("stiffness", &Oscillator::stiffness, "N/m", "of the spring", kPositive),
      field("length", &Oscillator::length, "m", "rest length of the spring", kPositive),
      field("amplitude", &Oscillator::amplitude, "m", "initial elongation, smaller than the rest length",
            kAnyNumber),
  };
  return list;
}

}  // namespace

Model make_oscillator(const Oscillator& o) {
  check_fields("model oscillator", fields(), o);
  if (!(std::abs(o.amplitude) < o.length))
    fail_input("model oscillator", "amplitude", o.amplitude, "m",
               "less than the rest length " + to_text(o.length));

  SystemBuilder builder;
  const Anchor wall = builder.add_world_point(Vector3d::Zero());
  const Anchor mass = builder.add_particle(o.mass, {o.length + o.amplitude, 0.0, 0.0});
  builder.add_distance(wall, mass, {o.stiffness, 0.0}, o.length);
  auto [system, state] = builder.build();

  Model model{"oscillator", std::move(system), state};
  const double omega = std::sqrt(o.stiffness / o.mass);
  model.end_time = 2.0 * 2.0 * std::numbers::pi / omega;
  model.scene_length = o.length;
  model.exact = [o, omega, state = state](double t) {
    State s = state;
    s.t = t;
    s.q[3] = o.length + o.amplitude * std::cos(omega * t);
    s.v[3] = -o.amplitude * omega * std::sin(omega * t);
    return s;
  };
  model.conserved = {conserved_energy()};
  return model;
}

ModelInfo oscillator_model() {
  return describe("oscillator", "one mass on a spring, moving along it; exact", fields(), make_oscillator);
}

}  // namespace feder
