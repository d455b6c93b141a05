// Nodes as in cloth.cpp, the centre of the obstacle in the origin and its top at y = radius or tube.
#include "models/cloth_drop.h"

#include "models/cloth.h"
#include "models/ground.h"
#include "models/parameters.h"

namespace feder {
namespace {

constexpr double kEndTime = 0.6;  // [s]
constexpr int kCloth = 1;         // group of its colliders
const char* const kPlace = "model cloth_drop";

const Fields<ClothDrop>& fields() {
  using C = ClothDrop;
  static const Fields<C> list = {
      field("n", &C::n, "nodes along an edge", count_from(2)),
      field("obstacle", &C::obstacle, "what it falls on", {"sphere", "torus"}),
      field("radius", &C::radius, "m", "of the sphere, of the torus' circle", kPositive),
      field("tube", &C::tube, "m", "radius of the torus' tube", kPositive),
      field("height", &C::height, "m", "of the cloth above the obstacle", kNonNegative),
      field("thickness", &C::thickness, "m", "of the cloth", kPositive),
      field("friction", &C::friction, "", "Coulomb's mu", kNonNegative),
      field("edge", &C::edge, "m", "length of an edge", kPositive),
      field("mass", &C::mass, "kg", "of the whole cloth", kPositive),
      field("stiffness", &C::stiffness, "N/m", "structural springs", kPositiveOrRigid),
      field("shear_stiffness", &C::shear_stiffness, "N/m", "both diagonals", kNonNegative),
      field("bend_stiffness", &C::bend_stiffness, "N/m", "springs to second neighbours", kNonNegative),
      field("damping_time", &C::damping_time, "s", "row damping tau", kNonNegative),
      field("drag", &C::drag, "kg/s", "linear drag of each node", kNonNegative),
      field("gravity", &C::gravity, "m/s^2", "along -y", kAnyNumber),
  };
  return list;
}

}  // namespace

Model make_cloth_drop(const ClothDrop& o) {
  check_fields(kPlace, fields(), o);
  const bool ring = o.obstacle == ClothObstacle::kTorus;
  if (ring && !(o.tube < o.radius))
    fail_input(kPlace, "tube", o.tube, "m", "less than radius = " + to_text(o.radius) + " m");
  const double half = 0.5 * o.thickness, top = ring ? o.tube : o.radius;
  const Surface surface{o.friction, 0.0};
  SystemBuilder builder;
  const int first = add_cloth(builder,
                              {.n = o.n,
                               .edge = o.edge,
                               .mass = o.mass,
                               .stiffness = o.stiffness,
                               .shear_stiffness = o.shear_stiffness,
                               .bend_stiffness = o.bend_stiffness,
                               .gravity = o.gravity,
                               .damping_time = o.damping_time,
                               .drag = o.drag},
                              {-0.5 * o.edge, top + half + o.height, -0.5 * o.edge}, false);
  for (int i = 0; i < o.n * o.n; ++i) builder.add_collider({first + i}, SphereShape{half}, surface, kCloth);
  const Shape obstacle = ring ? Shape(TorusShape{o.radius, o.tube}) : Shape(SphereShape{o.radius});
  builder.add_collider(builder.add_world_point(Vector3d::Zero()), obstacle, surface, 0,
                       axes_along(Vector3d::UnitY()));
  auto [system, state] = builder.build();

  Model model{"cloth_drop", std::move(system), std::move(state)};
  model.end_time = kEndTime;
  model.scene_length = o.edge;
  return model;
}

ModelInfo cloth_drop_model() {
  return describe("cloth_drop", "a cloth falls over a fixed sphere or torus", fields(), make_cloth_drop);
}

}  // namespace feder
