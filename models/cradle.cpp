// Ball i hangs on node 2 i below (i pitch, 0, 0), pitch = 2 radius + gap, and is node 2 i + 1. Balls of equal
// mass that meet with e = 1 exchange their velocities.
#include "models/cradle.h"

#include <numbers>

#include "models/parameters.h"

namespace feder {
namespace {

const char* const kPlace = "model cradle";

const Fields<Cradle>& fields() {
  static const Fields<Cradle> list = {
      field("n", &Cradle::n, "balls", count_from(2)),
      field("lifted", &Cradle::lifted, "balls let go at `angle`", count_from(0)),
      field("angle", &Cradle::angle, "rad", "from hanging, towards -x", {0.0, 0.5 * std::numbers::pi}),
      field("gap", &Cradle::gap, "m", "between neighbours at rest", kNonNegative),
      field("restitution", &Cradle::restitution, "", "e", {0.0, 1.0}),
      field("mass", &Cradle::mass, "kg", "of each ball", kPositive),
      field("radius", &Cradle::radius, "m", "of each ball", kPositive),
      field("length", &Cradle::length, "m", "of the rods", kPositive),
      field("stiffness", &Cradle::stiffness, "N/m", "of the rods", kPositiveOrRigid),
      field("gravity", &Cradle::gravity, "m/s^2", "along -y", kPositive),
  };
  return list;
}

}  // namespace

Model make_cradle(const Cradle& o) {
  check_fields(kPlace, fields(), o);
  if (o.lifted > o.n) fail_input(kPlace, "lifted", o.lifted, "", "at most n = " + std::to_string(o.n));
  SystemBuilder builder;
  for (int i = 0; i < o.n; ++i) {
    const double angle = i < o.lifted ? o.angle : 0.0;
    const Vector3d pivot(i * (2.0 * o.radius + o.gap), 0.0, 0.0);
    const Anchor support = builder.add_world_point(pivot);
    const Anchor ball =
        builder.add_particle(o.mass, pivot - o.length * Vector3d(std::sin(angle), std::cos(angle), 0.0),
                             Vector3d::Zero(), kPlanarXY);
    builder.add_distance(support, ball, {o.stiffness, 0.0}, o.length);
    builder.add_collider(ball, SphereShape{o.radius}, {0.0, o.restitution});
  }
  builder.set_gravity({0.0, -o.gravity, 0.0});
  auto [system, state] = builder.build();

  Model model{"cradle", std::move(system), std::move(state)};
  model.end_time = std::numbers::pi * std::sqrt(o.length / o.gravity);  // half a small swing
  model.scene_length = o.length;
  if (o.restitution == 1.0) model.conserved = {conserved_energy()};
  return model;
}

ModelInfo cradle_model() {
  return describe("cradle", "Newton's cradle: balls on rods that meet pair after pair", fields(),
                  make_cradle);
}

}  // namespace feder
