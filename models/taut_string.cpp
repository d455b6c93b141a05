// Beads at i span / (n + 1), springs of rest length link - tension / stiffness. Across the string only the
// geometric stiffness tension / link acts: omega_j = 2 sqrt(tension / (mass link)) sin(j pi / (2 (n + 1)))
// for small deflections.
#include "models/taut_string.h"

#include <cmath>
#include <numbers>

#include "engine/check.h"
#include "models/parameters.h"

namespace feder {
namespace {

constexpr const char* kPlace = "model taut_string";

const Fields<TautString>& fields() {
  static const Fields<TautString> list = {
      field("n", &TautString::n, "beads", count_from(1)),
      field("mass", &TautString::mass, "kg", "of each bead", kPositive),
      field("stiffness", &TautString::stiffness, "N/m", "of each of the n + 1 springs", kPositive),
      field("span", &TautString::span, "m", "distance of the fixed points", kPositive),
      field("tension", &TautString::tension, "N", "at rest, below stiffness times link length", kNonNegative),
      field("modes", &TautString::modes, "initial displacement along y as modes and amplitudes"),
      field("damping_time", &TautString::damping_time, "s", "row damping tau", kNonNegative),
      field("drag", &TautString::drag, "kg/s", "linear drag of each bead", kNonNegative),
  };
  return list;
}

double link(const TautString& o) {
  return o.span / (o.n + 1);
}

Vector3d start(const TautString& o, int i) {
  Vector3d position(i * o.span / (o.n + 1), 0.0, 0.0);
  if (i > 0 && i <= o.n)
    for (const Mode& mode : o.modes)
      position.y() += mode.amplitude * mode_shape(o.n, mode_index(kPlace, mode, o.n), i);
  return position;
}

}  // namespace

double taut_string_frequency(const TautString& o, int j) {
  return mode_frequency(o.n, j, o.tension / link(o), o.mass);
}

Model make_taut_string(const TautString& o) {
  check_fields(kPlace, fields(), o);
  const double rest = link(o) - o.tension / o.stiffness;
  if (!(rest > 0.0))
    fail_input(kPlace, "tension", o.tension, "N",
               "less than stiffness times link length = " + to_text(o.stiffness * link(o)));

  SystemBuilder builder;
  Anchor last = builder.add_world_point(start(o, 0));
  for (int i = 1; i <= o.n + 1; ++i) {
    const Anchor next =
        i <= o.n ? builder.add_particle(o.mass, start(o, i)) : builder.add_world_point(start(o, i));
    builder.add_distance(last, next, {o.stiffness, o.damping_time}, rest);
    last = next;
  }
  builder.set_drag(o.drag);
  auto [system, state] = builder.build();

  // two swings of the lowest transverse mode, along the string if there is no tension
  Model model{"taut_string", std::move(system), std::move(state)};
  const double omega =
      o.tension > 0.0 ? taut_string_frequency(o, 1) : mode_frequency(o.n, 1, o.stiffness, o.mass);
  model.end_time = 2.0 * 2.0 * std::numbers::pi / omega;
  model.scene_length = o.span;
  if (o.damping_time == 0.0 && o.drag == 0.0) model.conserved = {conserved_energy()};
  return model;
}

ModelInfo taut_string_model() {
  return describe("taut_string", "n beads on a prestretched string, swinging across it", fields(),
                  make_taut_string);
}

}  // namespace feder
