#include "models/dam_break.h"

#include <cmath>

#include "engine/check.h"

namespace feder {
namespace {

constexpr const char* kPlace = "model dam_break";

const Fields<DamBreak>& fields() {
  using D = DamBreak;
  static const Fields<D> list = [] {
    Fields<D> own = {
        field("layers", &D::layers, "of particles in the height", count_from(2)),
        field("slices", &D::slices, "of particles across, 0: in the plane", count_from(0)),
        field("height", &D::height, "m", "of the fluid", kPositive),
        field("width", &D::width, "m", "of the fluid", kPositive),
        field("length", &D::length, "m", "of the tank, more than width", kPositive),
    };
    add_fluid_fields(own);
    return own;
  }();
  return list;
}

}  // namespace

double front(const System& s, const State& state, double reach) {
  FluidPairs pairs;
  double x = -HUGE_VAL;
  if (!s.fluid->find_pairs(state.q, pairs)) return std::nan("");
  std::vector<int> near(pairs.size(), 0);
  for (int i = 0; i < pairs.size(); ++i)
    for (int k = pairs.first[i]; k < pairs.first[i + 1]; ++k) {
      const int j = pairs.neighbour[k];
      double squared = 0.0;
      for (int c = 0; c < pairs.dimension; ++c)
        squared += (pairs.x[c][i] - pairs.x[c][j]) * (pairs.x[c][i] - pairs.x[c][j]);
      if (squared < reach * reach && pairs.is_fluid(i) && pairs.is_fluid(j)) ++near[i], ++near[j];
    }
  for (int i = 0; i < pairs.size(); ++i)
    if (near[i] > 1) x = std::max(x, pairs.x[0][i]);
  return x;
}

Model make_dam_break(const DamBreak& o) {
  check_fields(kPlace, fields(), o);
  if (!(o.length > o.width))
    fail_input(kPlace, "length", o.length, "m", "more than width = " + to_text(o.width) + " m");
  const double spacing = o.height / o.layers;
  const int columns = std::max(1, static_cast<int>(std::lround(std::min(1e9, o.width / spacing))));
  const int slices = std::max(1, o.slices);
  require_count(kPlace, "particles", 1.0 * o.layers * columns * slices, kMaxNodes);
  require_count(kPlace, "boundary samples", o.length / spacing * slices, kMaxNodes);
  FluidScene scene(o, o.slices > 0 ? 3 : 2, spacing);
  for (double y : scene.settled_heights(o.layers, o.gravity))
    for (int i = 0; i < columns; ++i)
      for (int k = 0; k < slices; ++k)
        scene.add_particle({(i + 0.5) * spacing, y, o.slices > 0 ? (k + 0.5) * spacing : 0.0});
  scene.add_tank(o.length, 1.5 * o.height, slices * spacing);
  Model model = scene.finish("dam_break");
  model.end_time = 2.0 * std::sqrt(o.height / o.gravity);
  model.scene_length = o.length;
  model.conserved = conserved_by_fluid(o);
  return model;
}

ModelInfo dam_break_model() {
  return describe("dam_break", "a block of fluid runs out over a dry floor", fields(), make_dam_break);
}

}  // namespace feder
