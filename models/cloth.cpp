// S2(n): node i n + j at (i, 0, j) edge / (n - 1); springs to (1, 0), (0, 1), (1, 1), (1, -1), (2, 0), (0,
// 2).
#include "models/cloth.h"

#include "models/parameters.h"

namespace feder {
namespace {

constexpr double kEndTime = 0.25;  // [s]

const Fields<Cloth>& fields() {
  static const Fields<Cloth> list = {
      field("n", &Cloth::n, "nodes along an edge", count_from(2)),
      field("edge", &Cloth::edge, "m", "length of an edge", kPositive),
      field("mass", &Cloth::mass, "kg", "of the whole cloth", kPositive),
      field("stiffness", &Cloth::stiffness, "N/m", "structural springs", kPositiveOrRigid),
      field("shear_stiffness", &Cloth::shear_stiffness, "N/m", "both diagonals", kNonNegative),
      field("bend_stiffness", &Cloth::bend_stiffness, "N/m", "springs to second neighbours", kNonNegative),
      field("gravity", &Cloth::gravity, "m/s^2", "along -y", kAnyNumber),
      field("damping_time", &Cloth::damping_time, "s", "row damping tau", kNonNegative),
      field("drag", &Cloth::drag, "kg/s", "linear drag of each node", kNonNegative),
  };
  return list;
}

}  // namespace

double cloth_springs(int count) {
  const double n = count;
  return 2.0 * n * (n - 1.0) + 2.0 * (n - 1.0) * (n - 1.0) + 2.0 * n * (n - 2.0);
}

int add_cloth(SystemBuilder& builder, const Cloth& o, const Vector3d& at, bool pinned) {
  check_fields("model cloth", fields(), o);
  const int n = o.n;
  require_count("model cloth", "nodes n^2", static_cast<double>(n) * n, kMaxNodes);
  require_count("model cloth", "springs", cloth_springs(n), kMaxRows);

  int first = -1;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const bool corner = pinned && i == 0 && (j == 0 || j == n - 1);
      const Anchor node = builder.add_particle(o.mass / (n * n),
                                               at + Vector3d(i * o.edge / (n - 1), 0.0, j * o.edge / (n - 1)),
                                               Vector3d::Zero(), corner ? kPinned : kFree);
      if (first < 0) first = node.node;
    }

  // rest lengths as placed
  struct Spring {
    int di, dj;
    double stiffness;
  };
  const Spring springs[] = {{0, 1, o.stiffness},        {1, 0, o.stiffness},      {1, 1, o.shear_stiffness},
                            {1, -1, o.shear_stiffness}, {0, 2, o.bend_stiffness}, {2, 0, o.bend_stiffness}};
  for (const Spring& s : springs)
    for (int i = 0; i + s.di < n; ++i)
      for (int j = 0; j < n; ++j)
        if (j + s.dj >= 0 && j + s.dj < n)
          builder.add_distance({first + i * n + j}, {first + (i + s.di) * n + j + s.dj},
                               {s.stiffness, o.damping_time});
  builder.set_gravity({0.0, -o.gravity, 0.0});
  builder.set_drag(o.drag);
  return first;
}

Model make_cloth(const Cloth& o) {
  SystemBuilder builder;
  add_cloth(builder, o, Vector3d::Zero(), true);
  auto [system, state] = builder.build();

  Model model{"cloth", std::move(system), std::move(state)};
  model.end_time = kEndTime;
  model.scene_length = o.edge;
  if (o.damping_time == 0.0 && o.drag == 0.0) model.conserved = {conserved_energy()};
  return model;
}

ModelInfo cloth_model() {
  return describe("cloth", "n x n net in the xz plane, pinned at two corners, falling from rest", fields(),
                  make_cloth, {{"S2", "n", {}, "1 m x 1 m, 1 kg, springs 1e5 and 1e4 N/m"}});
}

}  // namespace feder
