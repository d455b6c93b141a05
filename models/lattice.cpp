// S4(n): node (i n + j) n + k at (i, j, k) edge / (n - 1); springs to the 13 neighbours that come later in
// this order and, seen from there, to the 13 earlier ones.
#include "models/lattice.h"

#include "models/parameters.h"

namespace feder {
namespace {

constexpr double kEndTime = 0.25;  // [s]

const Fields<Lattice>& fields() {
  static const Fields<Lattice> list = {
      field("n", &Lattice::n, "nodes along an edge", count_from(2)),
      field("edge", &Lattice::edge, "m", "length of an edge", kPositive),
      field("mass", &Lattice::mass, "kg", "of the whole cube", kPositive),
      field("stiffness", &Lattice::stiffness, "N/m", "times 1 / (n - 1): of each spring", kPositive),
      field("gravity", &Lattice::gravity, "m/s^2", "along -y", kAnyNumber),
      field("damping_time", &Lattice::damping_time, "s", "row damping tau", kNonNegative),
      field("drag", &Lattice::drag, "kg/s", "linear drag of each node", kNonNegative),
  };
  return list;
}

// springs from every node to its neighbour at (di, dj, dk)
void add_springs(SystemBuilder& builder, int n, int di, int dj, int dk, const Material& material) {
  auto inside = [n](int i) { return i >= 0 && i < n; };
  for (int i = 0; i + di < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k)
        if (inside(j + dj) && inside(k + dk))
          builder.add_distance({(i * n + j) * n + k}, {((i + di) * n + j + dj) * n + k + dk}, material);
}

}  // namespace

double lattice_springs(int count) {
  const double n = count, m = n - 1.0;
  return 3.0 * n * n * m + 6.0 * n * m * m + 4.0 * m * m * m;
}

Model make_lattice(const Lattice& o) {
  check_fields("model lattice", fields(), o);
  const int n = o.n;
  const double nodes = static_cast<double>(n) * n * n;
  require_count("model lattice", "nodes n^3", nodes, kMaxNodes);
  require_count("model lattice", "springs", lattice_springs(n), kMaxRows);

  SystemBuilder builder;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k)
        builder.add_particle(o.mass / nodes, Vector3d(i, j, k) * o.edge / (n - 1), Vector3d::Zero(),
                             i == 0 ? kPinned : kFree);
  const Material material{o.stiffness / (n - 1), o.damping_time};
  for (int di = 0; di <= 1; ++di)
    for (int dj = -1; dj <= 1; ++dj)
      for (int dk = -1; dk <= 1; ++dk)
        if (di > 0 || dj > 0 || (dj == 0 && dk > 0)) add_springs(builder, n, di, dj, dk, material);
  builder.set_gravity({0.0, -o.gravity, 0.0});
  builder.set_drag(o.drag);
  auto [system, state] = builder.build();

  Model model{"lattice", std::move(system), std::move(state)};
  model.end_time = kEndTime;
  model.scene_length = o.edge;
  if (o.damping_time == 0.0 && o.drag == 0.0) model.conserved = {conserved_energy()};
  return model;
}

ModelInfo lattice_model() {
  return describe("lattice", "cube of n^3 nodes tied to 26 neighbours, face x = 0 pinned, sagging", fields(),
                  make_lattice,
                  {{"S4", "n", {}, "1 m cube, 1 kg, springs 200/(n-1) N/m"},
                   {"S4s", "n", {{"stiffness", "20000"}}, "the same, 100 times stiffer"}});
}

}  // namespace feder
