// m x'' = -d (|x| - length) x / |x| + m g in the xy plane.
#include "models/spring_pendulum.h"

#include <cmath>
#include <numbers>

#include "engine/check.h"
#include "models/parameters.h"

namespace feder {
namespace {

using P = SpringPendulum;

const Fields<P>& fields() {
  static const Fields<P> list = {
      field("mass", &P::mass, "kg", "the mass", kPositive),
      field("length", &P::length, "m", "rest length of the spring", kPositive),
      field("stiffness", &P::stiffness, "N/m", "of the spring", kPositive),
      field("angle", &P::angle, "rad", "initial angle from hanging", kAnyNumber),
      field("elongation", &P::elongation, "m", "initial stretch of the spring, above -length", kAnyNumber),
      field("speed", &P::speed, "m/s", "initial velocity across the spring", kAnyNumber),
      field("gravity", &P::gravity, "m/s^2", "along -y", kPositive),
  };
  return list;
}

}  // namespace

Model make_spring_pendulum(const SpringPendulum& o) {
  check_fields("model spring_pendulum", fields(), o);
  if (!(o.elongation > -o.length))
    fail_input("model spring_pendulum", "elongation", o.elongation, "m",
               "more than -length = " + to_text(-o.length));

  SystemBuilder builder;
  const double c = std::cos(o.angle), s = std::sin(o.angle), radius = o.length + o.elongation;
  const Anchor pivot = builder.add_world_point(Vector3d::Zero());
  const Anchor mass = builder.add_particle(o.mass, {radius * s, -radius * c, 0.0},
                                           {o.speed * c, o.speed * s, 0.0}, kPlanarXY);
  builder.add_distance(pivot, mass, {o.stiffness, 0.0}, o.length);
  builder.set_gravity({0.0, -o.gravity, 0.0});
  auto [system, state] = builder.build();

  Model model{"spring_pendulum", std::move(system), std::move(state)};
  model.end_time = 2.0 * std::numbers::pi * std::sqrt(o.length / o.gravity);
  model.scene_length = o.length;
  model.conserved = {conserved_energy()};
  return model;
}

ModelInfo spring_pendulum_model() {
  return describe("spring_pendulum", "one mass on a stiff spring, swinging in a plane", fields(),
                  make_spring_pendulum);
}

}  // namespace feder
