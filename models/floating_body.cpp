// The fluid fills the tank to `layers` spacings, but for the places the box takes; the box begins with its
// bottom on a border of layers, the one next to Archimedes' depth, plus `lift`.
#include "models/floating_body.h"

#include <cmath>

#include "engine/check.h"
#include "engine/mass_properties.h"

namespace feder {
namespace {

constexpr const char* kPlace = "model floating_body";

const Fields<FloatingBody>& fields() {
  using F = FloatingBody;
  static const Fields<F> list = [] {
    Fields<F> own = {
        field("spacing", &F::spacing, "m", "of the particles", kPositive),
        field("columns", &F::columns, "of the tank, at least wide + 4", count_from(6)),
        field("layers", &F::layers, "of the fluid", count_from(4)),
        field("wide", &F::wide, "spacings the box is wide", count_from(2)),
        field("high", &F::high, "spacings the box is high", count_from(2)),
        field("density", &F::density, "", "of the box over that of the fluid", {0.01, 20.0}),
        field("lift", &F::lift, "m", "of the box over Archimedes' depth at the start", kAnyNumber),
    };
    add_fluid_fields(own);
    return own;
  }();
  return list;
}

// Layers of fluid the box displaces at the start.
int layers_displaced(const FloatingBody& o) {
  return static_cast<int>(std::lround(std::min(1.0, o.density) * o.high));
}

}  // namespace

double draft(const FloatingBody& o, const System& s, const State& state) {
  VectorXd rho;
  s.fluid->densities(state.q, rho);
  double volume = 0.0;  // over the length of the tank; at the surface sums of neighbours are no densities
  for (double density : rho)
    volume += o.spacing / o.columns * std::min(1.0, s.fluid->material().rest_density / density);
  const double bottom = state.q[3 * s.bodies[0].centre + 1] - 0.5 * o.high * o.spacing;
  return (volume - bottom) / (1.0 - static_cast<double>(o.wide) / o.columns);
}

Model make_floating_body(const FloatingBody& o) {
  check_fields(kPlace, fields(), o);
  if (o.columns < o.wide + 4) fail_input(kPlace, "columns", o.columns, "", "at least wide + 4");
  const int displaced = layers_displaced(o);
  if (o.layers < displaced + 3)
    fail_input(kPlace, "layers", o.layers, "", "3 more than the box displaces, " + std::to_string(displaced));
  require_count(kPlace, "columns times layers", 1.0 * o.columns * o.layers, kMaxNodes);
  require_count(kPlace, "wide times high", 1.0 * o.wide * o.high, kMaxNodes);
  const double s = o.spacing, width = o.wide * s, height = o.high * s;
  const int left = (o.columns - o.wide) / 2, below = o.layers - displaced;

  FluidScene scene(o, 2, s);
  const std::vector<double> heights = scene.settled_heights(o.layers, o.gravity);
  for (int j = 0; j < o.layers; ++j)
    for (int i = 0; i < o.columns; ++i)
      if (j < below || i < left || i >= left + o.wide) scene.add_particle({(i + 0.5) * s, heights[j], 0.0});
  scene.add_tank(o.columns * s, (o.layers + 6) * s, 0.0);

  SystemBuilder::BodyStart start;
  start.position = {(left + 0.5 * o.wide) * s, below * s + 0.5 * height + o.lift, 0.0};
  start.free = kPlanarXY;
  start.free_spin = 4;  // about z
  const double mass = o.density * o.rest_density * width * height;
  const Anchor box = scene.builder.add_body(solid_box(kPlace, mass, {width, height, width}), start);
  const Vector3d corner(0.5 * width, 0.5 * height, 0.0);
  scene.add_solid(
      -corner, corner,
      [&](const Vector3d& x) { return std::abs(x[0]) < corner[0] && std::abs(x[1]) < corner[1]; }, box);

  Model model = scene.finish("floating_body");
  model.end_time = o.density > 1.0 ? std::sqrt(2.0 * below * s / (o.gravity * (1.0 - 1.0 / o.density)))
                                   : 8.0 * std::sqrt(height / o.gravity);
  model.scene_length = o.columns * s;
  model.conserved = conserved_by_fluid(o);
  return model;
}

ModelInfo floating_body_model() {
  return describe("floating_body", "a box floats or sinks in a tank by its density", fields(),
                  make_floating_body);
}

}  // namespace feder
