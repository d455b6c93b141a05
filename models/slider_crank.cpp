// Bodies: crank, rod, slider; the slider's centre is at x = r cos a + sqrt(l^2 - r^2 sin^2 a).
#include "models/slider_crank.h"

#include <cmath>

#include "engine/check.h"
#include "engine/joints.h"
#include "models/parameters.h"
#include "models/planar_linkage.h"

namespace feder {
namespace {

using S = SliderCrank;
constexpr double kEndTime = 1.0;  // [s]

const Fields<S>& fields() {
  static const Fields<S> list = {
      field("crank", &S::crank, "m", "length of the crank, less than the rod's", kPositive),
      field("rod", &S::rod, "m", "length of the rod", kPositive),
      field("crank_mass", &S::crank_mass, "kg", "of the crank", kPositive),
      field("rod_mass", &S::rod_mass, "kg", "of the rod", kPositive),
      field("slider_mass", &S::slider_mass, "kg", "of the slider", kPositive),
      field("width", &S::width, "m", "of the bars' square sections", kPositive),
      field("slider_edge", &S::slider_edge, "m", "of the slider, a cube", kPositive),
      field("angle", &S::angle, "rad", "of the crank from the guide", kAnyNumber),
      field("speed", &S::speed, "rad/s", "of the crank, kept by the motor", kAnyNumber),
      field("drive", &S::drive, "free: only started; motor: turned at constant speed", {"free", "motor"}),
      field("gravity", &S::gravity, "m/s^2", "along -y", kAnyNumber),
  };
  return list;
}

}  // namespace

Model make_slider_crank(const S& o) {
  const char* const place = "model slider_crank";
  check_fields(place, fields(), o);
  if (!(o.crank < o.rod)) fail_input(place, "crank", o.crank, "m", "less than the rod = " + to_text(o.rod));
  const PlaneTurn crank_turn{o.angle, o.speed};
  const PlanePoint pin = along({}, crank_turn, o.crank);
  const double rod_angle = -std::asin(pin.place.y() / o.rod);
  const PlaneTurn rod_turn{rod_angle, -pin.velocity.y() / (o.rod * std::cos(rod_angle))};
  const PlanePoint end = along(pin, rod_turn, o.rod);

  SystemBuilder builder;
  const LinkagePlane plane;
  const Anchor crank = add_bar(builder, place, plane, {o.crank_mass, o.crank, o.width}, {}, crank_turn);
  const Anchor rod = add_bar(builder, place, plane, {o.rod_mass, o.rod, o.width}, pin, rod_turn);
  const Vector3d centre(end.place.x(), 0.0, 0.0);
  const Anchor slider = builder.add_body(solid_box(place, o.slider_mass, Vector3d::Constant(o.slider_edge)),
                                         {.position = centre, .velocity = {end.velocity.x(), 0.0, 0.0}});
  add_hinge(builder, {}, crank, Vector3d::Zero(), plane.axis());
  add_hinge(builder, crank, rod, plane.at(pin.place), plane.axis());
  add_hinge(builder, rod, slider, centre, plane.axis());
  add_prismatic(builder, {}, slider, centre, Vector3d::UnitX());
  if (o.drive == CrankDrive::kMotor)
    add_turn(builder, {}, crank, plane.axis(), {kRigid}, steady_target(0.0, o.speed));
  builder.set_gravity({0.0, -o.gravity, 0.0});
  auto [system, state] = builder.build();

  Model model{"slider_crank", std::move(system), std::move(state)};
  model.end_time = kEndTime;
  model.scene_length = o.crank + o.rod;
  if (o.drive == CrankDrive::kCoasting) model.conserved = {conserved_energy()};
  return model;
}

ModelInfo slider_crank_model() {
  return describe("slider_crank", "crank, rod and a slider in a guide, free or with a motor: redundant rows",
                  fields(), make_slider_crank);
}

}  // namespace feder
