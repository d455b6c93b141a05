// Bodies: crank, rocker, then the coupler's bars from B to C. It starts straight, moving as a rigid coupler
// would, with the spring at rest.
#include "models/flexible_linkage.h"

#include "engine/joints.h"
#include "models/parameters.h"
#include "models/planar_linkage.h"

namespace feder {
namespace {

using L = FlexibleLinkage;
constexpr double kEndTime = 1.0;  // [s]

const Fields<L>& fields() {
  static const Fields<L> list = {
      field("ground", &L::ground, "m", "between the fixed hinges", kPositive),
      field("crank", &L::crank, "m", "length of the crank", kPositive),
      field("coupler", &L::coupler, "m", "length of the coupler", kPositive),
      field("rocker", &L::rocker, "m", "length of the rocker", kPositive),
      field("segments", &L::segments, "bars of the coupler", count_from(2)),
      field("density", &L::density, "kg/m", "of the bars", kPositive),
      field("width", &L::width, "m", "of the bars' square sections", kPositive),
      field("stiffness", &L::stiffness, "N/m", "of the welds against parting", kPositive),
      field("angular_stiffness", &L::angular_stiffness, "N m", "of the welds against bending", kPositive),
      field("damping_time", &L::damping_time, "s", "row damping tau of the welds", kNonNegative),
      field("spring", &L::spring, "N/m", "from the coupler's middle to the ground", kPositive),
      field("angle", &L::angle, "rad", "of the crank from the ground line", kAnyNumber),
      field("speed", &L::speed, "rad/s", "of the crank at the start", kAnyNumber),
      field("tilt", &L::tilt, "rad", "of the plane out of xy, about (1, 2, 2)", kAnyNumber),
      field("gravity", &L::gravity, "m/s^2", "along -y", kAnyNumber),
  };
  return list;
}

// The coupler's bars in order.
std::vector<Anchor> add_coupler(SystemBuilder& builder, const std::string& place, const LinkagePlane& plane,
                                const L& o, const FourBarMotion& motion) {
  const double length = o.coupler / o.segments;
  const JointMaterial weld{.linear = {o.stiffness, o.damping_time},
                           .angular = {o.angular_stiffness, o.damping_time}};
  std::vector<Anchor> bars;
  for (int i = 0; i < o.segments; ++i) {
    const PlanePoint from = along(motion.B, motion.coupler, i * length);
    bars.push_back(
        add_bar(builder, place, plane, {o.density * length, length, o.width}, from, motion.coupler));
    if (i > 0) add_weld(builder, bars[i - 1], bars[i], plane.at(from.place), weld);
  }
  return bars;
}

}  // namespace

Model make_flexible_linkage(const L& o) {
  const char* const place = "model flexible_linkage";
  check_fields(place, fields(), o);
  require_count(place, "rows", 6.0 * o.segments + 20.0, kMaxRows);
  const FourBarMotion motion =
      four_bar_motion(place, {o.ground, o.crank, o.coupler, o.rocker}, {o.angle, o.speed}, false);
  SystemBuilder builder;
  const LinkagePlane plane = tilted_plane(o.tilt);
  const PlanePoint A, D{{o.ground, 0.0}};
  const Anchor crank =
      add_bar(builder, place, plane, {o.density * o.crank, o.crank, o.width}, A, motion.crank);
  const Anchor rocker =
      add_bar(builder, place, plane, {o.density * o.rocker, o.rocker, o.width}, D, motion.rocker);
  const std::vector<Anchor> coupler = add_coupler(builder, place, plane, o, motion);
  add_hinge(builder, {}, crank, plane.at(A.place), plane.axis());
  add_hinge(builder, crank, coupler.front(), plane.at(motion.B.place), plane.axis());
  add_hinge(builder, coupler.back(), rocker, plane.at(motion.C.place), plane.axis());
  add_hinge(builder, rocker, {}, plane.at(D.place), plane.axis());
  const Vector3d held = plane.at(along(motion.B, motion.coupler, 0.5 * o.coupler).place),
                 foot = plane.at({0.5 * o.ground, -0.5 * o.ground});
  AnchorDistanceRow spring{
      {builder.add_world_point(foot), builder.anchor_at(coupler[coupler.size() / 2], held), o.spring},
      (held - foot).norm()};
  builder.add(spring);
  builder.set_gravity({0.0, -o.gravity, 0.0});
  auto [system, state] = builder.build();

  Model model{"flexible_linkage", std::move(system), std::move(state)};
  model.end_time = kEndTime;
  model.scene_length = o.ground + o.crank;
  if (o.damping_time == 0.0) model.conserved = {conserved_energy()};
  return model;
}

ModelInfo flexible_linkage_model() {
  return describe("flexible_linkage",
                  "a four-bar linkage with a soft coupler on a spring: hard and soft rows", fields(),
                  make_flexible_linkage);
}

}  // namespace feder
