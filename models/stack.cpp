// Cube i is body i, its centre at (i + 1/2) edge. Every face carries the weight above it.
#include "models/stack.h"

#include "models/ground.h"
#include "models/parameters.h"

namespace feder {
namespace {

constexpr double kEndTime = 1.0;  // [s]

const Fields<Stack>& fields() {
  static const Fields<Stack> list = {
      field("n", &Stack::n, "cubes", count_from(1)),
      field("edge", &Stack::edge, "m", "of each cube", kPositive),
      field("mass", &Stack::mass, "kg", "of each cube but the top one", kPositive),
      field("ratio", &Stack::ratio, "", "mass of the top cube over that of the others", kPositive),
      field("friction", &Stack::friction, "", "Coulomb's mu", kNonNegative),
      field("gravity", &Stack::gravity, "m/s^2", "along -y", kPositive),
  };
  return list;
}

}  // namespace

Model make_stack(const Stack& o) {
  check_fields("model stack", fields(), o);
  const Surface surface{o.friction, 0.0};
  SystemBuilder builder;
  add_plane(builder, Vector3d::Zero(), Vector3d::UnitY(), surface);
  for (int i = 0; i < o.n; ++i) {
    const double mass = i == o.n - 1 ? o.mass * o.ratio : o.mass;
    const Anchor cube = builder.add_body(solid_box("model stack", mass, Vector3d::Constant(o.edge)),
                                         {.position = {0.0, (i + 0.5) * o.edge, 0.0}});
    builder.add_collider(cube, BoxShape{Vector3d::Constant(0.5 * o.edge)}, surface);
  }
  builder.set_gravity({0.0, -o.gravity, 0.0});
  auto [system, state] = builder.build();

  Model model{"stack", std::move(system), state};
  model.end_time = kEndTime;
  model.scene_length = o.n * o.edge;
  model.exact = [start = state](double t) { return State{t, start.q, start.v}; };
  return model;
}

ModelInfo stack_model() {
  return describe("stack", "a tower of cubes with a light or heavy one on top; it rests", fields(),
                  make_stack);
}

}  // namespace feder
