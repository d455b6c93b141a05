// S1(N), S1h(N): nodes 0 ... n along +x, node 0 fixed, at rest under gravity.
#include "models/hanging_chain.h"

#include <cmath>

#include "models/parameters.h"

namespace feder {
namespace {

using H = HangingChain;
constexpr double kEndTime = 0.25;  // [s]

const Fields<H>& fields() {
  static const Fields<H> list = {
      field("n", &H::n, "masses", count_from(1)),
      field("mass", &H::mass, "kg", "of each node", kPositive),
      field("stiffness", &H::stiffness, "N/m", "of each link", kPositiveOrRigid),
      field("link", &H::link, "m", "length of a link", kPositive),
      field("gravity", &H::gravity, "m/s^2", "along -y", kAnyNumber),
      field("damping_time", &H::damping_time, "s", "row damping tau", kNonNegative),
      field("drag", &H::drag, "kg/s", "linear drag of each node", kNonNegative),
      field("load", &H::load, "kg", "added to the last mass", kNonNegative),
      field("angle", &H::angle, "rad", "below the horizontal", kAnyNumber),
  };
  return list;
}

}  // namespace

Model make_hanging_chain(const HangingChain& o) {
  check_fields("model hanging_chain", fields(), o);
  const Vector3d along(std::cos(o.angle), 0.0 - std::sin(o.angle), 0.0);
  SystemBuilder builder;
  Anchor last = builder.add_world_point(Vector3d::Zero());
  for (int i = 1; i <= o.n; ++i) {
    const double mass = i < o.n ? o.mass : o.mass + o.load;
    const Anchor next = builder.add_particle(mass, i * o.link * along);
    builder.add_distance(last, next, {o.stiffness, o.damping_time}, o.link);
    last = next;
  }
  builder.set_gravity({0.0, -o.gravity, 0.0});
  builder.set_drag(o.drag);
  auto [system, state] = builder.build();

  Model model{"hanging_chain", std::move(system), std::move(state)};
  model.end_time = kEndTime;
  model.scene_length = o.link * o.n;
  if (o.damping_time == 0.0 && o.drag == 0.0) model.conserved = {conserved_energy()};
  return model;
}

ModelInfo hanging_chain_model() {
  return describe("hanging_chain", "n masses along +x on links, one end fixed, falling from rest", fields(),
                  make_hanging_chain,
                  {{"S1", "n", {}, "stiff springs"}, {"S1h", "n", {{"stiffness", "rigid"}}, "rods"}});
}

}  // namespace feder
