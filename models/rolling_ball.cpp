// With slip u = v - r w (w forwards) and inertia k m r^2, Coulomb friction gives, while u != 0,
//   v' = -mu g sgn u,   r w' = mu g sgn u / k,   u' = -mu g (1 + 1/k) sgn u
// and then u = 0 for good: from w = 0 at v = v0 / (1 + k), 5/7 v0 for a solid ball.
#include "models/rolling_ball.h"

#include <cmath>

#include "models/ground.h"
#include "models/parameters.h"

namespace feder {
namespace {

constexpr double kEndTime = 1.0;  // [s]
const char* const kPlace = "model rolling_ball";

const Fields<RollingBall>& fields() {
  static const Fields<RollingBall> list = {
      field("mass", &RollingBall::mass, "kg", "of the ball", kPositive),
      field("radius", &RollingBall::radius, "m", "of the ball", kPositive),
      field("hollow", &RollingBall::hollow, "", "radius of the hole inside, of the ball's", {0.0, 0.999}),
      field("speed", &RollingBall::speed, "m/s", "at the start, along +x", kAnyNumber),
      field("spin", &RollingBall::spin, "rad/s", "at the start, forwards", kAnyNumber),
      field("friction", &RollingBall::friction, "", "Coulomb's mu", kNonNegative),
      field("gravity", &RollingBall::gravity, "m/s^2", "along -y", kPositive),
  };
  return list;
}

}  // namespace

double ball_inertia_ratio(double hollow) {
  return 0.4 * (1.0 - std::pow(hollow, 5)) / (1.0 - std::pow(hollow, 3));
}

double RollingLaw::slip_time(Roll start) const {
  const double slip = std::abs(start.speed - radius * start.spin);
  return slip == 0.0 ? 0.0 : slip / (rub * (1.0 + 1.0 / ratio));
}

Roll RollingLaw::after(Roll at, double t) const {
  const double slip = at.speed - radius * at.spin, slipping = std::min(t, slip_time(at));
  const double a = -std::copysign(rub, slip), b = -a / (ratio * radius);
  at.way += slipping * (at.speed + 0.5 * a * slipping);
  at.turn += slipping * (at.spin + 0.5 * b * slipping);
  at.speed += a * slipping;
  at.spin += b * slipping;
  at.way += (t - slipping) * at.speed;
  at.turn += (t - slipping) * at.spin;
  return at;
}

Conserved conserved_rolling_momentum(double radius) {
  return {"angular momentum about the lowest point", "kg m^2/s", [radius](const System& s, const State& at) {
            const Body& b = s.bodies[0];
            return s.mass[b.centre] * radius * at.v[3 * b.centre] -
                   b.moments[2] * angular_velocity(b, at).z();
          }};
}

Model make_rolling_ball(const RollingBall& o) {
  check_fields(kPlace, fields(), o);
  const double ratio = ball_inertia_ratio(o.hollow);
  const MassProperties ball{o.mass, Vector3d::Zero(),
                            ratio * o.mass * o.radius * o.radius * Matrix3d::Identity()};
  const Surface surface{o.friction, 0.0};
  SystemBuilder builder;
  add_plane(builder, Vector3d::Zero(), Vector3d::UnitY(), surface);
  const Anchor body = builder.add_body(ball, {.position = {0.0, o.radius, 0.0},
                                              .velocity = {o.speed, 0.0, 0.0},
                                              .angular_velocity = {0.0, 0.0, -o.spin}});
  builder.add_collider(body, SphereShape{o.radius}, surface);
  builder.set_gravity({0.0, -o.gravity, 0.0});
  auto [system, state] = builder.build();

  Model model{"rolling_ball", std::move(system), state};
  model.end_time = kEndTime;
  model.scene_length = o.radius;
  const RollingLaw law{o.radius, ratio, o.friction * o.gravity};
  model.exact = [=, start = state, b = model.system.bodies[0]](double t) {
    const Roll at = law.after({.speed = o.speed, .spin = o.spin}, t);
    return moved_body(start, b, t, Vector3d::UnitZ(),
                      {{at.way, 0.0, 0.0}, {at.speed, 0.0, 0.0}, -at.turn, -at.spin});
  };
  model.exact_is_smooth = o.friction == 0.0 || o.speed == o.radius * o.spin;
  model.conserved = {conserved_rolling_momentum(o.radius)};
  if (o.friction == 0.0) model.conserved.push_back(conserved_energy());
  return model;
}

ModelInfo rolling_ball_model() {
  return describe("rolling_ball", "a ball that slides on a rough plane until it rolls; exact", fields(),
                  make_rolling_ball);
}

}  // namespace feder
