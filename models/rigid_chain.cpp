// S3c(N): boxes 0 ... n - 1 along +x, box i from i link to (i + 1) link.
#include "models/rigid_chain.h"

#include "models/parameters.h"

namespace feder {
namespace {

using C = RigidChain;
constexpr double kEndTime = 0.25;  // [s]

const Fields<C>& fields() {
  static const Fields<C> list = {
      field("n", &C::n, "boxes", count_from(1)),
      field("mass", &C::mass, "kg", "of each box", kPositive),
      field("link", &C::link, "m", "length of a box", kPositive),
      field("width", &C::width, "m", "of its square section", kPositive),
      field("stiffness", &C::stiffness, "N/m", "of each ball joint", kPositiveOrRigid),
      field("damping_time", &C::damping_time, "s", "row damping tau", kNonNegative),
      field("gravity", &C::gravity, "m/s^2", "along -y", kAnyNumber),
  };
  return list;
}

}  // namespace

Model make_rigid_chain(const RigidChain& o) {
  check_fields("model rigid_chain", fields(), o);
  const MassProperties box = solid_box("model rigid_chain", o.mass, {o.link, o.width, o.width});
  SystemBuilder builder;
  Anchor last = builder.add_world_point(Vector3d::Zero());
  for (int i = 0; i < o.n; ++i) {
    const int body = builder.add_body(box, {.position = {(i + 0.5) * o.link, 0.0, 0.0}}).body;
    builder.add(
        BallRow{{last, {.body = body, .point = {-0.5 * o.link, 0.0, 0.0}}, o.stiffness, o.damping_time}});
    last = {.body = body, .point = {0.5 * o.link, 0.0, 0.0}};
  }
  builder.set_gravity({0.0, -o.gravity, 0.0});
  auto [system, state] = builder.build();

  Model model{"rigid_chain", std::move(system), std::move(state)};
  model.end_time = kEndTime;
  model.scene_length = o.link * o.n;
  if (o.damping_time == 0.0) model.conserved = {conserved_energy()};
  return model;
}

ModelInfo rigid_chain_model() {
  return describe("rigid_chain", "n boxes along +x on ball joints, one end fixed, falling from rest",
                  fields(), make_rigid_chain, {{"S3c", "n", {}, "hard joints"}});
}

}  // namespace feder
