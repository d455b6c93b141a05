// Lagrange's top. With A the moment across and C that about the axis, both about the support, w3 the spin and
// p the precession, the tilt stays where A p^2 cos(tilt) - C w3 p + m g d = 0 (Goldstein, Classical
// Mechanics, section 5.7). Conserved: energy, C w3 and the vertical angular momentum about the support.
#include "models/heavy_top.h"

#include <Eigen/Geometry>

#include "engine/check.h"
#include "engine/energy.h"
#include "models/parameters.h"

namespace feder {
namespace {

using T = HeavyTop;
constexpr double kEndTime = 2.0;  // [s]
const char* const kPlace = "model heavy_top";

const Fields<T>& fields() {
  static const Fields<T> list = {
      field("mass", &T::mass, "kg", "of the cylinder", kPositive),
      field("radius", &T::radius, "m", "of the cylinder", kPositive),
      field("height", &T::height, "m", "of the cylinder, along its axis", kPositive),
      field("distance", &T::distance, "m", "of its centre from the support", kPositive),
      field("spin", &T::spin, "rad/s", "angular velocity about its own axis", kAnyNumber),
      field("tilt", &T::tilt, "rad", "of its axis from upright", kAnyNumber),
      field("precession", &T::precession, "rad/s", "of its axis about the vertical, if released", kAnyNumber),
      field("start", &T::start, "released with `precession`, or steady: at constant tilt",
            {"released", "steady"}),
      field("stiffness", &T::stiffness, "N/m", "of the support", kPositiveOrRigid),
      field("gravity", &T::gravity, "m/s^2", "along -y", kPositive),
  };
  return list;
}

// About the centre, axis z.
MassProperties cylinder(const T& o) {
  return solid_cylinder(kPlace, o.mass, o.radius, o.height);
}

Conserved spin_momentum() {
  return {"spin momentum", "kg m^2/s", [](const System& s, const State& at) {
            const Body& b = s.bodies[0];
            return b.moments[2] * at.v[3 * b.spin + 2];
          }};
}

}  // namespace

double steady_precession(const T& o) {
  const Matrix3d I = cylinder(o).inertia;
  const double across = I(0, 0) + o.mass * o.distance * o.distance, momentum = I(2, 2) * std::abs(o.spin),
               weight = o.mass * o.gravity * o.distance;
  const double least2 = 4.0 * across * weight * std::cos(o.tilt), root2 = momentum * momentum - least2;
  if (!(root2 >= 0.0))
    fail_input(kPlace, "spin", o.spin, "rad/s",
               "at least " + to_text(std::sqrt(least2) / I(2, 2)) + " for a steady precession");
  return std::copysign(2.0 * weight / (momentum + std::sqrt(root2)), o.spin);
}

Model make_heavy_top(const T& o) {
  check_fields(kPlace, fields(), o);
  const Vector3d up = Vector3d::UnitY(),
                 figure = std::cos(o.tilt) * up + std::sin(o.tilt) * Vector3d::UnitZ();
  Matrix3d axes;
  axes << Vector3d::UnitX(), figure.cross(Vector3d::UnitX()), figure;
  const double precession = o.start == TopStart::kSteady ? steady_precession(o) : o.precession;
  SystemBuilder builder;
  const Anchor support = builder.add_world_point(Vector3d::Zero());
  const Vector3d turning = o.spin * figure + precession * (up - std::cos(o.tilt) * figure);
  const Anchor top = builder.add_body(
      moved(cylinder(o), Matrix3d::Identity(), {0.0, 0.0, o.distance}),
      {.orientation = axes, .velocity = turning.cross(o.distance * figure), .angular_velocity = turning});
  builder.add(BallRow{{support, top, o.stiffness}});
  builder.set_gravity({0.0, -o.gravity, 0.0});
  auto [system, state] = builder.build();

  Model model{"heavy_top", std::move(system), std::move(state)};
  model.end_time = kEndTime;
  model.scene_length = o.distance + 0.5 * o.height;
  model.conserved = {conserved_energy(),
                     {"vertical angular momentum", "kg m^2/s",
                      [](const System& s, const State& at) { return angular_momentum(s, at).y(); }},
                     spin_momentum()};
  return model;
}

ModelInfo heavy_top_model() {
  return describe("heavy_top", "a cylinder spinning on a point of its axis under gravity", fields(),
                  make_heavy_top, {});
}

}  // namespace feder
