// Energy 1/2 EI int (psi')^2 ds, with psi' = kappa_row / l at an inner node over the length l: 1/2 (EI / l)
// kappa_row^2, so the curvature rows have stiffness EI / l, the distance rows EA / l, the nodes mass mu l
// (half at a free end). Clamped by nodes 0 and 1 the discrete rod deflects like one clamped midway: static
// tip deflection F l^3 / (3 EI) (N^3 - 3/2 N^2 + 1/2 N) = F L^3 / (3 EI) (1 + O(l^2)) for L = (N - 1/2) l, N
// = n - 1 links; hence l = L / (n - 3/2). Beam theory: omega_j = (beta_j)^2 / L^2 sqrt(EI / mu), beta: cos
// beta cosh beta = -1 (cantilever), j pi (pinned).
#include "models/bending_rod.h"

#include <cmath>
#include <numbers>

#include "engine/check.h"
#include "models/parameters.h"

namespace feder {
namespace {

using R = BendingRod;
constexpr const char* kPlace = "model bending_rod";
constexpr std::array<double, 3> kCantileverBeta = {1.875104068711961, 4.694091132974175, 7.854757438237613};

const Fields<R>& fields() {
  static const Fields<R> list = {
      field("n", &R::n, "nodes", count_from(3)),
      field("length", &R::length, "m", "of the rod", kPositive),
      field("line_density", &R::line_density, "kg/m", "mass per length", kPositive),
      field("bending_stiffness", &R::bending_stiffness, "N m^2", "EI", kPositive),
      field("axial_stiffness", &R::axial_stiffness, "N", "EA", kPositiveOrRigid),
      field("support", &R::support, "clamped and free, or pinned at both ends", {"cantilever", "pinned"}),
      field("amplitude", &R::amplitude, "m", "largest initial deflection, below length / 10", kAnyNumber),
      field("gravity", &R::gravity, "m/s^2", "along -y", kAnyNumber),
      field("damping_time", &R::damping_time, "s", "tau of all rows", kNonNegative),
      field("drag", &R::drag, "kg/s", "linear drag of each node", kNonNegative),
  };
  return list;
}

// first mode, largest value 1, at x / length
double first_mode(RodSupport support, double x) {
  if (support == RodSupport::kPinnedEnds) return std::sin(std::numbers::pi * x);
  const double b = kCantileverBeta[0];
  const double ratio = (std::sinh(b) - std::sin(b)) / (std::cosh(b) + std::cos(b));
  return 0.5 * (std::cosh(b * x) - std::cos(b * x) - ratio * (std::sinh(b * x) - std::sin(b * x)));
}

// Node positions in the first mode. Cantilever: links keep their length. Pinned: nodes move along y only.
std::vector<Vector3d> bent_shape(const BendingRod& o) {
  const bool cantilever = o.support == RodSupport::kCantilever;
  const double l = rod_link(o), first = cantilever ? -0.5 * l : 0.0;
  const double offset = cantilever ? first_mode(o.support, 0.5 * l / o.length) : 0.0;
  std::vector<Vector3d> points(o.n);
  for (int i = 0; i < o.n; ++i) {
    points[i] = {first + i * l, 0.0, 0.0};
    if (i < (cantilever ? 2 : 1) || (!cantilever && i == o.n - 1)) continue;
    points[i].y() = o.amplitude * (first_mode(o.support, (first + i * l) / o.length) - offset);
    const double rise = points[i].y() - points[i - 1].y();
    if (cantilever) points[i].x() = points[i - 1].x() + std::sqrt(l * l - rise * rise);
  }
  return points;
}

void check_options(const BendingRod& o) {
  check_fields(kPlace, fields(), o);
  if (!(std::abs(o.amplitude) < 0.1 * o.length))
    fail_input(kPlace, "amplitude", o.amplitude, "m", "less than length / 10 = " + to_text(0.1 * o.length));
  if (o.support == RodSupport::kPinnedEnds && std::isinf(o.axial_stiffness))
    fail_input(kPlace, "axial_stiffness", o.axial_stiffness, "N",
               "a finite number: between two fixed ends rigid links cannot bend");
}

}  // namespace

double rod_link(const BendingRod& o) {
  return o.length / (o.n - (o.support == RodSupport::kCantilever ? 1.5 : 1.0));
}

std::array<double, 3> beam_frequencies(const BendingRod& o) {
  std::array<double, 3> omega{};
  for (int j = 0; j < 3; ++j) {
    const double beta =
        o.support == RodSupport::kCantilever ? kCantileverBeta[j] : (j + 1) * std::numbers::pi;
    omega[j] = beta * beta / (o.length * o.length) * std::sqrt(o.bending_stiffness / o.line_density);
  }
  return omega;
}

Model make_bending_rod(const BendingRod& o) {
  check_options(o);
  const bool cantilever = o.support == RodSupport::kCantilever;
  const double l = rod_link(o);
  const std::vector<Vector3d> points = bent_shape(o);

  SystemBuilder builder;
  for (int i = 0; i < o.n; ++i) {
    const bool end = i == o.n - 1, fixed = i == 0 || (cantilever ? i == 1 : end);
    if (fixed)
      builder.add_world_point(points[i]);
    else
      builder.add_particle(o.line_density * l * (end ? 0.5 : 1.0), points[i]);
  }
  for (int i = cantilever ? 1 : 0; i + 1 < o.n; ++i)
    builder.add_distance({i}, {i + 1}, {o.axial_stiffness / l, o.damping_time}, l);
  for (int i = 1; i + 1 < o.n; ++i)
    builder.add(CurvatureRow{{i - 1, i, i + 1}, o.bending_stiffness / l, o.damping_time});
  builder.set_gravity({0.0, -o.gravity, 0.0});
  builder.set_drag(o.drag);
  auto [system, state] = builder.build();

  Model model{"bending_rod", std::move(system), std::move(state)};
  model.end_time = 2.0 * std::numbers::pi / beam_frequencies(o)[0];
  model.scene_length = o.length;
  if (o.damping_time == 0.0 && o.drag == 0.0) model.conserved = {conserved_energy()};
  return model;
}

ModelInfo bending_rod_model() {
  return describe("bending_rod", "elastic rod, clamped or pinned, started in its first bending mode",
                  fields(), make_bending_rod);
}

}  // namespace feder
