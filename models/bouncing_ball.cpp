// It first lands at t1 = sqrt(2 height/g) with v1 = g t1 and leaves its n-th bounce with e^n v1:
//   t_n = t1 (1 + 2 (e + ... + e^(n-1))),   t_n -> t1 (1 + e)/(1 - e)
// Each bounce pushes up by p = (1 + e) e^(n-1) m v1. Friction takes the slip u = v - r w whole if it can, by
// m u/(1
// + 1/k) with k = 2/5, otherwise mu p: v -= f/m, r w += f/(k m). Then it rolls (rolling_ball.h).
#include "models/bouncing_ball.h"

#include <algorithm>
#include <cmath>

#include "models/ground.h"
#include "models/parameters.h"
#include "models/rolling_ball.h"

namespace feder {
namespace {

constexpr double kRatio = 0.4;    // k
constexpr double kBounces = 6.0;  // watched where they never end
const char* const kPlace = "model bouncing_ball";

const Fields<BouncingBall>& fields() {
  using B = BouncingBall;
  static const Fields<B> list = {
      field("height", &B::height, "m", "of its lowest point at the start", kPositive),
      field("restitution", &B::restitution, "", "e", {0.0, 1.0}),
      field("speed", &B::speed, "m/s", "at the start, along +x", kAnyNumber),
      field("spin", &B::spin, "rad/s", "at the start, forwards", kAnyNumber),
      field("friction", &B::friction, "", "Coulomb's mu", kNonNegative),
      field("mass", &B::mass, "kg", "of the ball", kPositive),
      field("radius", &B::radius, "m", "of the ball", kPositive),
      field("gravity", &B::gravity, "m/s^2", "along -y", kPositive),
  };
  return list;
}

double first_bounce(const BouncingBall& o) {
  return std::sqrt(2.0 * o.height / o.gravity);
}

struct Flight {
  double up, rise;  // of the lowest point, and its rate
  Roll along;
};

Flight flight(const BouncingBall& o, double t) {
  const double g = o.gravity, e = o.restitution, t1 = first_bounce(o);
  Roll at{.speed = o.speed, .spin = o.spin};
  const auto move = [&at](double dt) { at.way += dt * at.speed, at.turn += dt * at.spin; };
  if (t <= t1) return move(t), Flight{o.height - 0.5 * g * t * t, -g * t, at};
  move(t1);
  const double end = bounce_time(o, INFINITY);
  double now = t1, speed = g * t1;
  // the slip is gone or shrinks by less than rounding where the bounces do
  for (double n = 1.0;; ++n) {
    const double slip = at.speed - o.radius * at.spin, most = o.friction * (1.0 + e) * speed,
                 push = std::clamp(slip / (1.0 + 1.0 / kRatio), -most, most);
    at.speed -= push;
    at.spin += push / (kRatio * o.radius);
    speed *= e;
    const double next = bounce_time(o, n + 1.0);
    if (t <= next || !(next > now)) break;
    move(next - now);
    now = next;
  }
  if (t < end) {
    const double left = t - now;
    move(left);
    return {left * (speed - 0.5 * g * left), speed - g * left, at};
  }
  return {0.0, 0.0, RollingLaw{o.radius, kRatio, o.friction * g}.after(at, t - end)};
}

}  // namespace

double bounce_time(const BouncingBall& o, double n) {
  const double e = o.restitution;
  const double sum = e < 1.0 ? e * (1.0 - std::pow(e, n - 1.0)) / (1.0 - e) : n - 1.0;
  return first_bounce(o) * (1.0 + 2.0 * sum);
}

Model make_bouncing_ball(const BouncingBall& o) {
  check_fields(kPlace, fields(), o);
  const Surface surface{o.friction, o.restitution};
  SystemBuilder builder;
  add_plane(builder, Vector3d::Zero(), Vector3d::UnitY(), surface);
  const Anchor ball =
      builder.add_body(solid_sphere(kPlace, o.mass, o.radius), {.position = {0.0, o.height + o.radius, 0.0},
                                                                .velocity = {o.speed, 0.0, 0.0},
                                                                .angular_velocity = {0.0, 0.0, -o.spin}});
  builder.add_collider(ball, SphereShape{o.radius}, surface);
  builder.set_gravity({0.0, -o.gravity, 0.0});
  auto [system, state] = builder.build();

  Model model{"bouncing_ball", std::move(system), state};
  model.end_time = o.restitution < 1.0 ? 1.5 * bounce_time(o, INFINITY) : bounce_time(o, kBounces);
  model.scene_length = o.height;
  model.exact = [=, start = state, b = model.system.bodies[0]](double t) {
    const Flight f = flight(o, t);
    return moved_body(
        start, b, t, Vector3d::UnitZ(),
        {{f.along.way, f.up - o.height, 0.0}, {f.along.speed, f.rise, 0.0}, -f.along.turn, -f.along.spin});
  };
  model.exact_is_smooth = false;
  model.conserved = {conserved_rolling_momentum(o.radius)};
  if (o.friction == 0.0) model.conserved.push_back(conserved_momentum("momentum along x", 0));
  if (o.friction == 0.0 && o.restitution == 1.0) model.conserved.push_back(conserved_energy());
  return model;
}

ModelInfo bouncing_ball_model() {
  return describe("bouncing_ball", "a ball bounces on a plane until it rolls; exact", fields(),
                  make_bouncing_ball);
}

}  // namespace feder
