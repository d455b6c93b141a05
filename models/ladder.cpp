// Statics (D'Alembert at rest): with N, F the normal and friction forces at floor (1) and wall (2), length L,
// radius r, N2 = F1, N1 + F2 = m g and, about the foot, m g L/2 cos = N2 (L sin + r) + F2 (L cos + r); at the
// threshold F1 = mu1 N1 and F2 = mu2 N2.
// Smooth: 1/2 J angle'^2 + 1/2 m g L sin(angle) is kept, J = m L^2/4 + I: a pendulum of frequency omega^2 =
// m g L/(2 J) at pi/2 + angle from hanging, see pendulum.cpp. The wall's force m x'' vanishes where cos
// angle'^2 = -sin angle'', that is at sin(angle) = 2/3 sin(start), whatever J.
#include "models/ladder.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "models/elliptic.h"
#include "models/ground.h"
#include "models/parameters.h"

namespace feder {
namespace {

constexpr double kRestTime = 1.0;  // [s]
constexpr double kRight = 0.5 * std::numbers::pi;
const char* const kPlace = "model ladder";

const Fields<Ladder>& fields() {
  static const Fields<Ladder> list = {
      field("length", &Ladder::length, "m", "between the centres of its ends", kPositive),
      field("radius", &Ladder::radius, "m", "of the bar and its ends", kPositive),
      field("mass", &Ladder::mass, "kg", "of the ladder", kPositive),
      field("angle", &Ladder::angle, "rad", "from the floor", {0.0, kRight, true}),
      field("floor_friction", &Ladder::floor_friction, "", "Coulomb's mu at the foot", kNonNegative),
      field("wall_friction", &Ladder::wall_friction, "", "Coulomb's mu at the top", kNonNegative),
      field("gravity", &Ladder::gravity, "m/s^2", "along -y", kPositive),
  };
  return list;
}

// About the centre, axis z.
MassProperties bar(const Ladder& o) {
  return solid_cylinder(kPlace, o.mass, o.radius, o.length);
}

double frequency(const Ladder& o) {
  const double J = 0.25 * o.mass * o.length * o.length + bar(o).inertia(0, 0);
  return std::sqrt(0.5 * o.mass * o.gravity * o.length / J);
}

struct Lean {
  double angle, rate;  // from the floor
};

// At omega t = u, between smooth surfaces.
Lean lean(const Ladder& o, double u) {
  const double start = 0.5 * (kRight + o.angle);
  const Modulus m{std::sin(start), std::cos(start)};
  const JacobiElliptic e = jacobi_elliptic(u, m);
  return {2.0 * std::atan2(m.k * e.cn, m.complement) - kRight,
          -2.0 * frequency(o) * m.k * m.complement * e.sn / e.dn};
}

Vector3d centre(const Ladder& o, double angle) {
  return {o.radius + 0.5 * o.length * std::cos(angle), o.radius + 0.5 * o.length * std::sin(angle), 0.0};
}

// Contacts take the geometric mean of the two frictions.
Surface rubbing(double friction) {
  return {friction * friction, 0.0};
}

}  // namespace

double ladder_threshold(const Ladder& o) {
  const double reach = o.length * std::cos(o.angle), height = o.length * std::sin(o.angle);
  return reach / (2.0 * (height + o.radius) + o.wall_friction * (reach + 2.0 * o.radius));
}

double ladder_leaving_angle(const Ladder& o) {
  return std::asin(2.0 / 3.0 * std::sin(o.angle));
}

double ladder_leaving_time(const Ladder& o) {
  const double start = 0.5 * (kRight + o.angle), angle = ladder_leaving_angle(o);
  double low = 0.0, high = elliptic_k({std::sin(start), std::cos(start)});
  for (double middle; middle = 0.5 * (low + high), middle > low && middle < high;)
    (lean(o, middle).angle > angle ? low : high) = middle;
  return low / frequency(o);
}

Model make_ladder(const Ladder& o) {
  check_fields(kPlace, fields(), o);
  const bool smooth = o.floor_friction == 0.0 && o.wall_friction == 0.0;
  const double start_angle = lean(o, 0.0).angle;
  const Vector3d along(-std::cos(start_angle), std::sin(start_angle), 0.0);
  Matrix3d axes;
  axes << Vector3d::UnitZ(), along.cross(Vector3d::UnitZ()), along;
  SystemBuilder builder;
  add_plane(builder, Vector3d::Zero(), Vector3d::UnitY(), rubbing(o.floor_friction));
  add_plane(builder, Vector3d::Zero(), Vector3d::UnitX(), rubbing(o.wall_friction));
  const Anchor ladder = builder.add_body(bar(o), {.position = centre(o, start_angle), .orientation = axes});
  builder.add_collider(ladder, CapsuleShape{o.radius, 0.5 * o.length}, {1.0, 0.0});
  builder.set_gravity({0.0, -o.gravity, 0.0});
  auto [system, state] = builder.build();

  Model model{"ladder", std::move(system), state};
  model.end_time = smooth ? ladder_leaving_time(o) : kRestTime;
  model.scene_length = o.length;
  if (o.floor_friction >= ladder_threshold(o))
    model.exact = [start = state](double t) { return State{t, start.q, start.v}; };
  if (smooth) {
    model.exact = [=, start = state, b = model.system.bodies[0]](double t) {
      const Lean at = lean(o, frequency(o) * t);
      const Vector3d v(-0.5 * o.length * std::sin(at.angle), 0.5 * o.length * std::cos(at.angle), 0.0);
      return moved_body(
          start, b, t, Vector3d::UnitZ(),
          {centre(o, at.angle) - centre(o, start_angle), at.rate * v, start_angle - at.angle, -at.rate});
    };
    model.conserved = {conserved_energy()};
  }
  return model;
}

ModelInfo ladder_model() {
  return describe("ladder", "a ladder on floor and wall: stands, or slides; exact if held or smooth",
                  fields(), make_ladder);
}

}  // namespace feder
