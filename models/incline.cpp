// Downhill, with n = m g cos(angle) and friction mu n against the velocity: s'' = g (sin(angle) -+ mu
// cos(angle)). It stops where s' = 0 and stays there if tan(angle) <= mu. Friction pulls at half the height,
// so the weight on the box's base stays within it, and the box does not tip, while mu (at rest: tan(angle))
// is below width / height = 2.
#include "models/incline.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "models/ground.h"
#include "models/parameters.h"

namespace feder {
namespace {

constexpr double kEndTime = 1.0;  // [s]
constexpr double kTips = 2.0;     // width / height

const Fields<Incline>& fields() {
  static const Fields<Incline> list = {
      field("angle", &Incline::angle, "rad", "of the plane from the horizontal",
            {0.0, 0.5 * std::numbers::pi}),
      field("friction", &Incline::friction, "", "Coulomb's mu", kNonNegative),
      field("speed", &Incline::speed, "m/s", "at the start, downhill", kAnyNumber),
      field("mass", &Incline::mass, "kg", "of the box", kPositive),
      field("edge", &Incline::edge, "m", "of the box, which is half as high", kPositive),
      field("gravity", &Incline::gravity, "m/s^2", "along -y", kPositive),
  };
  return list;
}

}  // namespace

Slide incline_slide(const Incline& o, double t) {
  const double pull = o.gravity * std::sin(o.angle), rub = o.friction * o.gravity * std::cos(o.angle);
  Slide at{0.0, o.speed};
  if (o.speed != 0.0) {
    const double a = pull - std::copysign(rub, o.speed), stop = -o.speed / a;
    const double sliding = stop > 0.0 ? std::min(t, stop) : t;
    at = {sliding * (o.speed + 0.5 * a * sliding),
          sliding < stop || stop <= 0.0 ? o.speed + a * sliding : 0.0};
    t -= sliding;
    if (at.speed != 0.0) return at;
  }
  const double a = std::max(0.0, pull - rub);
  return {at.way + 0.5 * a * t * t, a * t};
}

Model make_incline(const Incline& o) {
  check_fields("model incline", fields(), o);
  const Vector3d downhill(std::cos(o.angle), -std::sin(o.angle), 0.0),
      up(std::sin(o.angle), std::cos(o.angle), 0.0), edges(o.edge, 0.5 * o.edge, o.edge);
  Matrix3d axes;
  axes << downhill, up, Vector3d::UnitZ();
  const Surface surface{o.friction, 0.0};
  SystemBuilder builder;
  add_plane(builder, Vector3d::Zero(), up, surface);
  const Anchor box = builder.add_body(
      solid_box("model incline", o.mass, edges),
      {.position = 0.5 * edges.y() * up, .orientation = axes, .velocity = o.speed * downhill});
  builder.add_collider(box, BoxShape{0.5 * edges}, surface);
  builder.set_gravity({0.0, -o.gravity, 0.0});
  auto [system, state] = builder.build();

  Model model{"incline", std::move(system), state};
  model.end_time = kEndTime;
  model.scene_length = o.edge;
  const double rub = o.speed == 0.0 ? std::min(o.friction, std::tan(o.angle)) : o.friction;
  if (rub < kTips)
    model.exact = [=, start = state, body = model.system.bodies[0]](double t) {
      const Slide s = incline_slide(o, t);
      return moved_body(start, body, t, Vector3d::UnitZ(),
                        {.shift = s.way * downhill, .velocity = s.speed * downhill});
    };
  model.exact_is_smooth = o.speed == 0.0;
  if (o.friction == 0.0) model.conserved = {conserved_energy()};
  return model;
}

ModelInfo incline_model() {
  return describe("incline", "a box on a rough inclined plane: slides or rests; exact", fields(),
                  make_incline);
}

}  // namespace feder
