// The first ring lies flat at x < 0 and moves along +x, the second stands upright across its way; each has
// half the speed.
#include "models/mesh_collision.h"

#include <Eigen/Geometry>
#include <memory>
#include <numbers>

#include "engine/geometry/collision_mesh.h"
#include "engine/geometry/mesh_generators.h"
#include "models/ground.h"
#include "models/parameters.h"

namespace feder {
namespace {

constexpr double kEndTime = 0.3;  // [s]
const char* const kPlace = "model mesh_collision";

const Fields<MeshCollision>& fields() {
  using M = MeshCollision;
  static const Fields<M> list = {
      field("speed", &M::speed, "m/s", "of approach", kNonNegative),
      field("offset", &M::offset, "m", "of their paths", kAnyNumber),
      field("spin", &M::spin, "rad/s", "of both, about an axis askew to theirs", kAnyNumber),
      field("restitution", &M::restitution, "", "e", {0.0, 1.0}),
      field("friction", &M::friction, "", "Coulomb's mu", kNonNegative),
      field("density", &M::density, "kg/m^3", "of the first", kPositive),
      field("ratio", &M::ratio, "", "density of the second over that", kPositive),
      field("radius", &M::radius, "m", "of the rings' circle", kPositive),
      field("tube", &M::tube, "m", "radius of the rings' tube, below radius", kPositive),
      field("detail", &M::detail, "corners around the tube, half of those along the ring",
            {3, 1000, false, false, true}),
  };
  return list;
}

}  // namespace

Model make_mesh_collision(const MeshCollision& o) {
  check_fields(kPlace, fields(), o);
  if (!(o.tube < o.radius))
    fail_input(kPlace, "tube", o.tube, "m", "less than radius = " + to_text(o.radius) + " m");
  const TriangleMesh ring = torus_mesh(kPlace, o.radius, o.tube, 2 * o.detail, o.detail);
  const auto shape = std::make_shared<const CollisionMesh>(kPlace, ring);
  const Surface surface{o.friction, o.restitution};
  const Vector3d axis = Vector3d(0.6, 0.3, 0.9).normalized(),
                 reach(o.radius + 1.5 * o.tube, 0.5 * o.offset, 0.0), approach(0.5 * o.speed, 0.0, 0.0);
  SystemBuilder builder;
  for (const double side : {-1.0, 1.0}) {
    const Matrix3d axes =
        side < 0.0 ? Matrix3d::Identity()
                   : Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3d::UnitX()).toRotationMatrix();
    const double density = side < 0.0 ? o.density : o.density * o.ratio;
    const Anchor body =
        builder.add_body(solid_mesh(kPlace, density, ring), {.position = side * reach,
                                                             .orientation = axes,
                                                             .velocity = -side * approach,
                                                             .angular_velocity = side * o.spin * axis});
    builder.add_collider(body, MeshShape{shape}, surface);
  }
  auto [system, state] = builder.build();

  Model model{"mesh_collision", std::move(system), std::move(state)};
  model.end_time = kEndTime;
  model.scene_length = 2.0 * (o.radius + o.tube);
  for (int c = 0; c < 3; ++c) {
    const std::string along = std::string(" along ") + "xyz"[c];
    model.conserved.push_back(conserved_momentum("momentum" + along, c));
    model.conserved.push_back(conserved_angular_momentum("angular momentum" + along, c));
  }
  return model;
}

ModelInfo mesh_collision_model() {
  return describe("mesh_collision", "two rings of triangles fly at each other in free space", fields(),
                  make_mesh_collision);
}

}  // namespace feder
