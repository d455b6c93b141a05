// With I = m edge^2/6 about every axis and d the horizontal distance of the touching edge or corner from the
// centre, notes D3 reads, for an edge with equal impulses at its two ends,
//   p = (1 + e) v / (1/m + d^2/I),   v' = p/m - v,   w' = d p/I
// A face comes down with d = 0. Then the centre flies on a parabola and the cube keeps its spin, until the
// lowest of its corners s is down again: v' t - g t^2/2 + (R(w' t) s)_y + height of the centre = 0.
#include "models/drop.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "models/ground.h"
#include "models/parameters.h"

namespace feder {
namespace {

constexpr double kMostTilt = 0.6;  // the next corner is 0.615 away
constexpr int kLooks = 4096;       // for the second impact

const Fields<Drop>& fields() {
  static const Fields<Drop> list = {
      field("start", &Drop::start, "what it falls on", {"face", "edge", "corner"}),
      field("tilt", &Drop::tilt, "rad", "of edge or corner out of the vertical below the centre",
            {-kMostTilt, kMostTilt}),
      field("height", &Drop::height, "m", "of the lowest point", kPositive),
      field("restitution", &Drop::restitution, "", "e", {0.0, 1.0}),
      field("friction", &Drop::friction, "", "Coulomb's mu", kNonNegative),
      field("mass", &Drop::mass, "kg", "of the cube", kPositive),
      field("edge", &Drop::edge, "m", "of the cube", kPositive),
      field("gravity", &Drop::gravity, "m/s^2", "along -y", kPositive),
  };
  return list;
}

Matrix3d axes_of(const Drop& o) {
  if (o.start == DropStart::kFace) return Matrix3d::Identity();
  const Eigen::AngleAxisd tilt(o.tilt, Vector3d::UnitZ());
  if (o.start == DropStart::kEdge)
    return (tilt * Eigen::AngleAxisd(0.25 * std::numbers::pi, Vector3d::UnitZ())).toRotationMatrix();
  return (tilt * Eigen::Quaterniond::FromTwoVectors(Vector3d::Ones(), Vector3d::UnitY())).toRotationMatrix();
}

// Lowest point of the cube from its centre, in the middle of those that touch.
Vector3d lowest(const Drop& o) {
  if (o.start == DropStart::kFace) return {0.0, -0.5 * o.edge, 0.0};
  const double reach = 0.5 * o.edge * std::sqrt(o.start == DropStart::kEdge ? 2.0 : 3.0);
  return {reach * std::sin(o.tilt), -reach * std::cos(o.tilt), 0.0};
}

// Corner k from the centre, in the pose of the start.
std::array<Vector3d, 8> corners(const Drop& o) {
  const Matrix3d axes = axes_of(o);
  std::array<Vector3d, 8> all;
  for (int k = 0; k < 8; ++k)
    all[k] = axes * (0.5 * o.edge * Vector3d(k & 1 ? 1.0 : -1.0, k & 2 ? 1.0 : -1.0, k & 4 ? 1.0 : -1.0));
  return all;
}

double flight_time(const Drop& o, double v, double w) {
  const double start = -lowest(o).y(), g = o.gravity;
  const auto all = corners(o);
  const auto lowest_at = [&](double t) {
    double y = INFINITY;
    for (const Vector3d& s : all) y = std::min(y, std::sin(w * t) * s.x() + std::cos(w * t) * s.y());
    return start + t * (v - 0.5 * g * t) + y;
  };
  // the centre never is below half an edge
  const double longest = (v + std::sqrt(std::max(0.0, v * v + 2.0 * g * (start - 0.5 * o.edge)))) / g;
  double low = 0.0, high = longest;
  for (int i = 1; i <= kLooks; ++i)
    if (const double t = longest * i / kLooks; lowest_at(t) <= 0.0) {
      low = i == 1 ? 0.5 * t : longest * (i - 1) / kLooks, high = t;
      break;
    }
  for (double middle; middle = 0.5 * (low + high), middle > low && middle < high;)
    (lowest_at(middle) > 0.0 ? low : high) = middle;
  return low;
}

}  // namespace

DropImpact drop_impact(const Drop& o) {
  const double time = std::sqrt(2.0 * o.height / o.gravity), v = o.gravity * time;
  const double I = o.mass * o.edge * o.edge / 6.0, d = lowest(o).x();
  const double p = (1.0 + o.restitution) * v / (1.0 / o.mass + d * d / I);
  DropImpact impact{time, p, p / o.mass - v, d * p / I, 0.0};
  if (o.restitution > 0.0) impact.flight = flight_time(o, impact.velocity, impact.spin);
  return impact;
}

Model make_drop(const Drop& o) {
  check_fields("model drop", fields(), o);
  const Surface surface{o.friction, o.restitution};
  SystemBuilder builder;
  add_plane(builder, Vector3d::Zero(), Vector3d::UnitY(), surface);
  const Anchor cube =
      builder.add_body(solid_box("model drop", o.mass, Vector3d::Constant(o.edge)),
                       {.position = {0.0, o.height - lowest(o).y(), 0.0}, .orientation = axes_of(o)});
  builder.add_collider(cube, BoxShape{Vector3d::Constant(0.5 * o.edge)}, surface);
  builder.set_gravity({0.0, -o.gravity, 0.0});
  auto [system, state] = builder.build();

  Model model{"drop", std::move(system), state};
  const DropImpact hit = drop_impact(o);
  const bool stays = o.restitution == 0.0 && o.start == DropStart::kFace;
  model.end_time = hit.time + (hit.flight > 0.0 ? 0.9 * hit.flight : hit.time);
  model.scene_length = o.height;
  model.exact_is_smooth = false;
  const double d = lowest(o).x();
  if ((hit.flight > 0.0 || stays) && (o.friction == 0.0 || d == 0.0))
    model.exact = [=, start = state, b = model.system.bodies[0]](double t) {
      const double g = o.gravity, after = t - hit.time;
      BodyMotion at{{0.0, -0.5 * g * t * t, 0.0}, {0.0, -g * t, 0.0}};
      if (after > 0.0 && !stays)
        at = {{0.0, after * (hit.velocity - 0.5 * g * after) - o.height, 0.0},
              {0.0, hit.velocity - g * after, 0.0},
              hit.spin * after,
              hit.spin};
      if (after > 0.0 && stays) at = {{0.0, -o.height, 0.0}, Vector3d::Zero()};
      return moved_body(start, b, t, Vector3d::UnitZ(), at);
    };
  if (o.friction == 0.0)
    model.conserved = {conserved_momentum("momentum along x", 0), conserved_momentum("momentum along z", 2),
                       conserved_angular_momentum("vertical angular momentum", 1)};
  if (o.friction == 0.0 && o.restitution == 1.0) model.conserved.push_back(conserved_energy());
  return model;
}

ModelInfo drop_model() {
  return describe("drop", "a cube falls on its face, edge or corner; exact up to the second impact", fields(),
                  make_drop);
}

}  // namespace feder
