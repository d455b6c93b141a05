// Planar, with the inertia of its bars; bodies: upper, lower. Angles from hanging, positive about z.
#include "models/double_pendulum.h"

#include <numbers>

#include "engine/joints.h"
#include "models/parameters.h"
#include "models/planar_linkage.h"

namespace feder {
namespace {

using P = DoublePendulum;
constexpr double kEndTime = 2.0;  // [s]
constexpr double kHanging = -0.5 * std::numbers::pi;

const Fields<P>& fields() {
  static const Fields<P> list = {
      field("upper_mass", &P::upper_mass, "kg", "of the upper bar", kPositive),
      field("lower_mass", &P::lower_mass, "kg", "of the lower bar", kPositive),
      field("upper_length", &P::upper_length, "m", "of the upper bar", kPositive),
      field("lower_length", &P::lower_length, "m", "of the lower bar", kPositive),
      field("width", &P::width, "m", "of the bars' square sections", kPositive),
      field("upper_angle", &P::upper_angle, "rad", "of the upper bar from hanging", kAnyNumber),
      field("lower_angle", &P::lower_angle, "rad", "of the lower bar from hanging", kAnyNumber),
      field("upper_rate", &P::upper_rate, "rad/s", "of the upper bar", kAnyNumber),
      field("lower_rate", &P::lower_rate, "rad/s", "of the lower bar", kAnyNumber),
      field("stiffness", &P::stiffness, "N/m", "of the hinges' places", kPositiveOrRigid),
      field("angular_stiffness", &P::angular_stiffness, "N m", "of the hinges' axes", kPositiveOrRigid),
      field("gravity", &P::gravity, "m/s^2", "along -y", kPositive),
  };
  return list;
}

}  // namespace

Model make_double_pendulum(const P& o) {
  const char* const place = "model double_pendulum";
  check_fields(place, fields(), o);
  SystemBuilder builder;
  const LinkagePlane plane;
  const JointMaterial hinge{.linear = {o.stiffness}, .angular = {o.angular_stiffness}};
  const PlaneTurn upper{o.upper_angle + kHanging, o.upper_rate},
      lower{o.lower_angle + kHanging, o.lower_rate};
  const PlanePoint elbow = along({}, upper, o.upper_length);
  const Anchor first = add_bar(builder, place, plane, {o.upper_mass, o.upper_length, o.width}, {}, upper);
  const Anchor second = add_bar(builder, place, plane, {o.lower_mass, o.lower_length, o.width}, elbow, lower);
  add_hinge(builder, {}, first, Vector3d::Zero(), plane.axis(), hinge);
  add_hinge(builder, first, second, plane.at(elbow.place), plane.axis(), hinge);
  builder.set_gravity({0.0, -o.gravity, 0.0});
  auto [system, state] = builder.build();

  Model model{"double_pendulum", std::move(system), std::move(state)};
  model.end_time = kEndTime;
  model.scene_length = o.upper_length + o.lower_length;
  model.conserved = {conserved_energy()};
  return model;
}

ModelInfo double_pendulum_model() {
  return describe("double_pendulum", "two bars on hinges, swinging in a plane", fields(),
                  make_double_pendulum);
}

}  // namespace feder
