// S3b(nx, ny): d plates at -60 degrees, then nx - d at the angle a with (nx - d) sin a = d sin 60.
#include "models/plate_bridge.h"

#include <numbers>

#include "models/parameters.h"
#include "models/plates.h"

namespace feder {
namespace {

using B = PlateBridge;
constexpr double kDown = std::numbers::pi / 3.0;
constexpr double kEdge = 0.2;  // [m]

const Fields<B>& fields() {
  static const Fields<B> list = {
      field("nx", &B::nx, "plates along a row", count_from(2)),
      field("ny", &B::ny, "rows", count_from(1)),
      field("stiffness", &B::stiffness, "N/m", "of each ball joint", kPositiveOrRigid),
      field("damping_time", &B::damping_time, "s", "row damping tau", kNonNegative),
      field("gravity", &B::gravity, "m/s^2", "along -y", kAnyNumber),
  };
  return list;
}

std::vector<Vector3d> v_shape(int n) {
  const int down = static_cast<int>(std::lround(n / 3.0));
  const double drop = kEdge * std::sin(kDown), rise = drop * down / (n - down);
  const double step_down = kEdge * std::cos(kDown), step_up = std::sqrt(kEdge * kEdge - rise * rise);
  std::vector<Vector3d> points;
  for (int i = 0; i <= down; ++i) points.emplace_back(i * step_down, -i * drop, 0.0);
  for (int i = down + 1; i <= n; ++i)
    points.emplace_back(down * step_down + (i - down) * step_up, -(n - i) * rise, 0.0);
  return points;
}

}  // namespace

Model make_plate_bridge(const PlateBridge& o) {
  const std::string place = "model plate_bridge";
  check_fields(place, fields(), o);
  require_count(place, "nodes", 2.0 * o.nx * o.ny + 2.0 * o.ny, kMaxNodes);
  require_count(place, "rows", 3.0 * plate_joints(o.nx, o.ny, true), kMaxRows);
  return make_plates("plate_bridge", {.profile = v_shape(o.nx),
                                      .rows = o.ny,
                                      .edge = kEdge,
                                      .thickness = 0.02,
                                      .mass = 0.4,
                                      .last_tied = true,
                                      .stiffness = o.stiffness,
                                      .damping_time = o.damping_time,
                                      .gravity = o.gravity});
}

ModelInfo plate_bridge_model() {
  return describe("plate_bridge", "ny rows of nx plates on ball joints, hung at both ends as a V, from rest",
                  fields(), make_plate_bridge, {{"S3b", "nx,ny", {}, "hard joints"}});
}

}  // namespace feder
