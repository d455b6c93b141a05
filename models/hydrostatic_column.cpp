// Layers start where the pressure of their density carries what is above: p(y) = rho_0 g (depth - y).
#include "models/hydrostatic_column.h"

#include <cmath>

namespace feder {
namespace {

constexpr const char* kPlace = "model hydrostatic_column";

const Fields<HydrostaticColumn>& fields() {
  using H = HydrostaticColumn;
  static const Fields<H> list = [] {
    Fields<H> own = {
        field("layers", &H::layers, "of particles", count_from(4)),
        field("columns", &H::columns, "of particles", count_from(3)),
        field("depth", &H::depth, "m", "of the fluid", kPositive),
        field("push", &H::push, "m/s", "initial velocity of the surface, downwards", kAnyNumber),
    };
    add_fluid_fields(own);
    return own;
  }();
  return list;
}

}  // namespace

Model make_hydrostatic_column(const HydrostaticColumn& o) {
  check_fields(kPlace, fields(), o);
  require_count(kPlace, "layers times columns", 1.0 * o.layers * o.columns, kMaxNodes);
  const double spacing = o.depth / o.layers;
  FluidScene scene(o, 2, spacing);
  for (double y : scene.settled_heights(o.layers, o.gravity))
    for (int i = 0; i < o.columns; ++i)
      scene.add_particle({(i + 0.5) * spacing, y, 0.0}, {0.0, -o.push * y / o.depth, 0.0});
  scene.add_tank(o.columns * spacing, o.depth + 4.0 * spacing, 0.0);
  Model model = scene.finish("hydrostatic_column");
  model.end_time = 2.0 * std::sqrt(o.depth / o.gravity);
  model.scene_length = o.depth;
  model.conserved = conserved_by_fluid(o);
  return model;
}

ModelInfo hydrostatic_column_model() {
  return describe("hydrostatic_column", "a column of fluid between two walls, settled under its weight",
                  fields(), make_hydrostatic_column);
}

}  // namespace feder
