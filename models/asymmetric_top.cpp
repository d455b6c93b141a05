// A torque-free box. Conserved: energy and the world angular momentum.
#include "models/asymmetric_top.h"

#include <cmath>

#include "engine/energy.h"
#include "models/parameters.h"

namespace feder {
namespace {

using T = AsymmetricTop;
constexpr double kEndTime = 10.0;  // [s]

const Fields<T>& fields() {
  static const Fields<T> list = {
      field("mass", &T::mass, "kg", "of the box", kPositive),
      field("length", &T::length, "m", "edge along x", kPositive),
      field("width", &T::width, "m", "edge along y", kPositive),
      field("height", &T::height, "m", "edge along z", kPositive),
      field("speed", &T::speed, "rad/s", "of the rotation", kAnyNumber),
      field("tilt", &T::tilt, "rad", "of the rotation from the y axis", kAnyNumber),
  };
  return list;
}

}  // namespace

Model make_asymmetric_top(const AsymmetricTop& o) {
  check_fields("model asymmetric_top", fields(), o);
  SystemBuilder builder;
  const double across = std::sin(o.tilt) / std::sqrt(2.0);
  builder.add_body(solid_box("model asymmetric_top", o.mass, {o.length, o.width, o.height}),
                   {.angular_velocity = o.speed * Vector3d(across, std::cos(o.tilt), across)});
  auto [system, state] = builder.build();
  Model model{"asymmetric_top", std::move(system), std::move(state)};
  model.end_time = kEndTime;
  model.scene_length = o.length;
  model.conserved = {conserved_energy(),
                     {"angular momentum", "kg m^2/s",
                      [](const System& s, const State& at) { return angular_momentum(s, at).norm(); }}};
  return model;
}

ModelInfo asymmetric_top_model() {
  return describe("asymmetric_top", "a free box that spins about its middle axis and flips", fields(),
                  make_asymmetric_top, {});
}

}  // namespace feder
