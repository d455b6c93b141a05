// Bars 0 ... n - 1 from the support down; released from rest.
#include "models/n_pendulum.h"

#include <numbers>

#include "engine/joints.h"
#include "models/parameters.h"
#include "models/planar_linkage.h"

namespace feder {
namespace {

using P = NPendulum;
constexpr double kEndTime = 1.0;  // [s]

const Fields<P>& fields() {
  static const Fields<P> list = {
      field("n", &P::n, "bars", count_from(1)),
      field("mass", &P::mass, "kg", "of each bar", kPositive),
      field("link", &P::link, "m", "length of a bar", kPositive),
      field("width", &P::width, "m", "of its square section", kPositive),
      field("angle", &P::angle, "rad", "of all bars from hanging", kAnyNumber),
      field("stiffness", &P::stiffness, "N/m", "of the hinges' places", kPositiveOrRigid),
      field("angular_stiffness", &P::angular_stiffness, "N m", "of the hinges' axes", kPositiveOrRigid),
      field("gravity", &P::gravity, "m/s^2", "along -y", kPositive),
  };
  return list;
}

}  // namespace

Model make_n_pendulum(const P& o) {
  const char* const place = "model n_pendulum";
  check_fields(place, fields(), o);
  require_count(place, "nodes", 3.0 * o.n, kMaxNodes);
  require_count(place, "rows", 5.0 * o.n, kMaxRows);
  SystemBuilder builder;
  const LinkagePlane plane;
  const JointMaterial hinge{.linear = {o.stiffness}, .angular = {o.angular_stiffness}};
  const PlaneTurn turn{o.angle - 0.5 * std::numbers::pi};
  Anchor last;
  for (int i = 0; i < o.n; ++i) {
    const PlanePoint from = along({}, turn, i * o.link);
    const Anchor bar = add_bar(builder, place, plane, {o.mass, o.link, o.width}, from, turn);
    add_hinge(builder, last, bar, plane.at(from.place), plane.axis(), hinge);
    last = bar;
  }
  builder.set_gravity({0.0, -o.gravity, 0.0});
  auto [system, state] = builder.build();

  Model model{"n_pendulum", std::move(system), std::move(state)};
  model.end_time = kEndTime;
  model.scene_length = o.n * o.link;
  model.conserved = {conserved_energy()};
  return model;
}

ModelInfo n_pendulum_model() {
  return describe("n_pendulum", "n bars on hinges, straight and at rest at the start", fields(),
                  make_n_pendulum);
}

}  // namespace feder
