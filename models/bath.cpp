// Which lattice places lie inside the mesh: the solid angle of its triangles is 4 pi there, 0 outside (van
// Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30, 1983): tan(omega/2) = a.(b x c) / (abc + (a.b) c +
// (b.c) a + (c.a) b).
#include "models/bath.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "engine/check.h"
#include "engine/geometry/mesh_generators.h"
#include "engine/mass_properties.h"

namespace feder {
namespace {

constexpr const char* kPlace = "model bath";
constexpr double kTube = 0.35;  // radius of the torus' tube over that of the whole

const Fields<Bath>& fields() {
  static const Fields<Bath> list = [] {
    Fields<Bath> own = {
        field("spacing", &Bath::spacing, "m", "of the particles", kPositive),
        field("columns", &Bath::columns, "of the tank, both ways", count_from(4)),
        field("layers", &Bath::layers, "of the fluid", count_from(2)),
        field("shape", &Bath::shape, "of the mesh", {"sphere", "torus", "box"}),
        field("radius", &Bath::radius, "m", "half of the mesh's width, below half of the tank's", kPositive),
        field("density", &Bath::density, "", "of the solid over that of the fluid", {0.01, 20.0}),
        field("height", &Bath::height, "m", "of its lowest point over the fluid at the start", kNonNegative),
        field("spin", &Bath::spin, "rad/s", "about x at the start", kAnyNumber),
    };
    add_fluid_fields(own);
    return own;
  }();
  return list;
}

TriangleMesh mesh_of(const Bath& o) {
  constexpr int kAround = 24, kAcross = 12, kQuarter = 6;
  switch (o.shape) {
    case BathShape::kSphere:
      return sphere_mesh(kPlace, o.radius, kQuarter);
    case BathShape::kTorus:
      return torus_mesh(kPlace, (1.0 - kTube) * o.radius, kTube * o.radius, kAround, kAcross);
    case BathShape::kBox:
      return box_mesh(kPlace, Vector3d::Constant(2.0 * o.radius));
  }
  return {};
}

bool is_inside(const TriangleMesh& mesh, const Vector3d& x) {
  double angle = 0.0;
  for (const auto& [i, j, k] : mesh.triangles) {
    const Vector3d a = mesh.vertices[i] - x, b = mesh.vertices[j] - x, c = mesh.vertices[k] - x;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    angle +=
        2.0 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return angle > 2.0 * std::numbers::pi;
}

}  // namespace

Model make_bath(const Bath& o) {
  check_fields(kPlace, fields(), o);
  const double s = o.spacing, width = o.columns * s;
  if (!(2.0 * o.radius < width))
    fail_input(kPlace, "radius", o.radius, "m",
               "less than half of the tank's width, " + to_text(0.5 * width) + " m");
  require_count(kPlace, "particles", 1.0 * o.columns * o.columns * o.layers, kMaxNodes);
  FluidScene scene(o, 3, s);
  for (double y : scene.settled_heights(o.layers, o.gravity))
    for (int i = 0; i < o.columns; ++i)
      for (int k = 0; k < o.columns; ++k) scene.add_particle({(i + 0.5) * s, y, (k + 0.5) * s});
  scene.add_tank(width, (o.layers + 4) * s, width);

  const TriangleMesh mesh = mesh_of(o);
  double lowest = 0.0;
  for (const Vector3d& x : mesh.vertices) lowest = std::min(lowest, x[1]);
  const Anchor solid =
      scene.builder.add_body(solid_mesh(kPlace, o.density * o.rest_density, mesh),
                             {.position = {0.5 * width, o.layers * s + o.height - lowest, 0.5 * width},
                              .angular_velocity = {o.spin, 0.0, 0.0}});
  const Vector3d corner = Vector3d::Constant(std::ceil(o.radius / s) * s);
  scene.add_solid(
      -corner, corner, [&](const Vector3d& x) { return is_inside(mesh, x); }, solid);

  Model model = scene.finish("bath");
  const double fall = std::sqrt((o.height + o.layers * s) / o.gravity);
  model.end_time =
      o.density > 1.0 ? std::sqrt(2.0) * fall : 4.0 * fall;  // heavy: before it reaches the floor
  model.scene_length = width;
  model.conserved = conserved_by_fluid(o);
  return model;
}

ModelInfo bath_model() {
  return describe("bath", "a closed triangle mesh falls into a tank of fluid", fields(), make_bath);
}

}  // namespace feder
