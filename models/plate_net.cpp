#include "models/plate_net.h"

#include "models/parameters.h"
#include "models/plates.h"

namespace feder {
namespace {

using N = PlateNet;
constexpr double kEdge = 0.1;  // [m]

const Fields<N>& fields() {
  static const Fields<N> list = {
      field("n", &N::n, "plates along an edge", count_from(1)),
      field("stiffness", &N::stiffness, "N/m", "of each ball joint", kPositiveOrRigid),
      field("damping_time", &N::damping_time, "s", "row damping tau", kNonNegative),
      field("gravity", &N::gravity, "m/s^2", "along -y", kAnyNumber),
  };
  return list;
}

}  // namespace

Model make_plate_net(const PlateNet& o) {
  const std::string place = "model plate_net";
  check_fields(place, fields(), o);
  require_count(place, "nodes", 2.0 * o.n * o.n + o.n, kMaxNodes);
  require_count(place, "rows", 3.0 * plate_joints(o.n, o.n, false), kMaxRows);
  std::vector<Vector3d> flat;
  for (int i = 0; i <= o.n; ++i) flat.emplace_back(i * kEdge, 0.0, 0.0);
  return make_plates("plate_net", {.profile = std::move(flat),
                                   .rows = o.n,
                                   .edge = kEdge,
                                   .thickness = 0.02,
                                   .mass = 0.1,
                                   .last_tied = false,
                                   .stiffness = o.stiffness,
                                   .damping_time = o.damping_time,
                                   .gravity = o.gravity});
}

ModelInfo plate_net_model() {
  return describe("plate_net",
                  "n x n plates flat in the xz plane on ball joints, held along one edge, from rest",
                  fields(), make_plate_net);
}

}  // namespace feder
