// Bodies: crank AB, coupler BC, rocker DC with A = (0, 0) and D = (ground, 0) of the plane.
#include "models/four_bar.h"

#include "engine/joints.h"
#include "models/parameters.h"
#include "models/planar_linkage.h"

namespace feder {
namespace {

using F = FourBar;
constexpr double kEndTime = 1.2;  // [s]

const Fields<F>& fields() {
  static const Fields<F> list = {
      field("ground", &F::ground, "m", "between the fixed hinges", kPositive),
      field("crank", &F::crank, "m", "length of the crank", kPositive),
      field("coupler", &F::coupler, "m", "length of the coupler", kPositive),
      field("rocker", &F::rocker, "m", "length of the rocker", kPositive),
      field("density", &F::density, "kg/m", "of the bars", kPositive),
      field("width", &F::width, "m", "of the bars' square sections", kPositive),
      field("angle", &F::angle, "rad", "of the crank from the ground line", kAnyNumber),
      field("speed", &F::speed, "rad/s", "of the crank at the start", kAnyNumber),
      field("branch", &F::branch, "coupler and rocker meet left or right of the line between them",
            {"open", "crossed"}),
      field("tilt", &F::tilt, "rad", "of the plane out of xy, about (1, 2, 2)", kAnyNumber),
      field("gravity", &F::gravity, "m/s^2", "along -y", kAnyNumber),
  };
  return list;
}

}  // namespace

Model make_four_bar(const F& o) {
  const char* const place = "model four_bar";
  check_fields(place, fields(), o);
  const FourBarMotion motion = four_bar_motion(place, {o.ground, o.crank, o.coupler, o.rocker},
                                               {o.angle, o.speed}, o.branch == FourBarBranch::kCrossed);
  SystemBuilder builder;
  const LinkagePlane plane = tilted_plane(o.tilt);
  const PlanePoint A, D{{o.ground, 0.0}};
  auto bar = [&](double length, const PlanePoint& from, const PlaneTurn& turn) {
    return add_bar(builder, place, plane, {o.density * length, length, o.width}, from, turn);
  };
  const Anchor crank = bar(o.crank, A, motion.crank), coupler = bar(o.coupler, motion.B, motion.coupler),
               rocker = bar(o.rocker, D, motion.rocker);
  add_hinge(builder, {}, crank, plane.at(A.place), plane.axis());
  add_hinge(builder, crank, coupler, plane.at(motion.B.place), plane.axis());
  add_hinge(builder, coupler, rocker, plane.at(motion.C.place), plane.axis());
  add_hinge(builder, rocker, {}, plane.at(D.place), plane.axis());
  builder.set_gravity({0.0, -o.gravity, 0.0});
  auto [system, state] = builder.build();

  Model model{"four_bar", std::move(system), std::move(state)};
  model.end_time = kEndTime;
  model.scene_length = o.ground + o.crank;
  model.conserved = {conserved_energy()};
  return model;
}

ModelInfo four_bar_model() {
  return describe("four_bar", "crank, coupler and rocker on four parallel hinges: redundant rows", fields(),
                  make_four_bar);
}

}  // namespace feder
