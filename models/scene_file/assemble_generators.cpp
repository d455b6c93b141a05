#include <algorithm>
#include <cmath>

#include "models/scene_file/assembly.h"
#include "models/scene_file/surfaces.h"

namespace feder {
namespace {

bool has(const std::vector<std::string>& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

// Does i of n lie on the side "u0" or "u1" that was asked for?
bool on_side(const std::vector<std::string>& fixed, const std::string& axis, int i, int n) {
  return (i == 0 && has(fixed, axis + "0")) || (i == n - 1 && has(fixed, axis + "1"));
}

std::string indexed(const std::string& name, const std::array<int, 3>& at, int dimensions) {
  std::string text = name;
  for (std::size_t d = 0; d < static_cast<std::size_t>(dimensions); ++d)
    text.append(d == 0 ? "[" : ",").append(std::to_string(at[d]));
  return text.append("]");
}

}  // namespace

// Products of counts, in double, before anything is allocated.
bool Assembly::require_counts(const Entry& entry, double nodes, double rows) {
  if (nodes_ + nodes <= limits_.most_nodes && row_count_ + rows <= limits_.most_rows) {
    nodes_ += nodes, row_count_ += rows;
    return true;
  }
  tell(entry, entry.place,
       "it would have " + to_text(nodes) + " nodes and " + to_text(rows) + " rows, expected at most " +
           to_text(limits_.most_nodes) + " and " + to_text(limits_.most_rows) + " in the scene");
  return false;
}

bool Assembly::counts_of(const Entry& entry, const std::vector<double>& numbers, std::size_t wanted,
                         Grid& grid) {
  if (numbers.size() != wanted) {
    if (!entry.broken)
      tell(entry, entry.place,
           "count has " + std::to_string(numbers.size()) + " numbers, expected " + std::to_string(wanted));
    return false;
  }
  for (std::size_t d = 0; d < wanted; ++d) grid.count[d] = static_cast<int>(numbers[d]);
  grid.dimensions = static_cast<int>(wanted);
  return true;
}

template <class At>
bool Assembly::add_grid(const Entry& entry, const NameText& name, double mass, Grid& grid, At&& node_at) {
  const double total = static_cast<double>(grid.count[0]) * grid.count[1] * grid.count[2];
  if (group(name.value) < 0) return false;
  grid.first = static_cast<int>(scene_.nodes.size());
  grid.anchors.reserve(static_cast<std::size_t>(total));
  std::vector<int>& members = scene_.groups[static_cast<std::size_t>(group(name.value))].members;
  return attempt(entry, [&] {
    for (int i = 0; i < grid.count[0]; ++i)
      for (int j = 0; j < grid.count[1]; ++j)
        for (int k = 0; k < grid.count[2]; ++k) {
          const GridNode node = node_at(i, j, k);
          grid.anchors.push_back(node.fixed
                                     ? add_point(node.position)
                                     : add_particle(mass / total, node.position, Vector3d::Zero(), kFree));
          members.push_back(static_cast<int>(scene_.nodes.size()));
          name_node(entry, indexed(name.value, {i, j, k}, grid.dimensions), SceneNode::Kind::kParticle,
                    grid.anchors.back(), {});
        }
  });
}

void Assembly::add_grid_springs(const Entry& entry, const Grid& grid, const std::array<int, 3>& step,
                                const Material& material) {
  const auto& [ni, nj, nk] = grid.count;
  auto inside = [](int i, int n) { return i >= 0 && i < n; };
  for (int i = 0; i + step[0] < ni; ++i)
    for (int j = 0; j < nj; ++j)
      for (int k = 0; k < nk; ++k) {
        if (!inside(j + step[1], nj) || !inside(k + step[2], nk)) continue;
        const int from = grid.at(i, j, k), to = grid.at(i + step[0], j + step[1], k + step[2]);
        const Anchor a = grid.anchors[static_cast<std::size_t>(from)],
                     b = grid.anchors[static_cast<std::size_t>(to)];
        const double rest = (place_of(b) - place_of(a)).norm();
        const std::string& name_a = scene_.nodes[static_cast<std::size_t>(grid.first + from)].name;
        const std::string& name_b = scene_.nodes[static_cast<std::size_t>(grid.first + to)].name;
        // not inside the braces: gcc 12 destroys half-made aggregates twice where their last member throws
        const int id = builder_.add_distance(a, b, material, rest);
        rows_.push_back({{name_a + " - " + name_b, "distance", 0, 1, {a, b}}, id, &entry});
      }
}

void Assembly::add_chains() {
  for (const ChainEntry& entry : document_.chains) {
    if (!claim(entry, entry.name)) continue;
    names_[entry.name.value] = {};
    Material m;
    if (!material_of(entry, entry, -1.0, m)) continue;
    const double n = entry.count, bending = entry.bending_stiffness > 0.0 ? 3.0 * n : 0.0;
    if (!require_counts(entry, n, n + bending)) continue;
    Grid grid{{entry.count, 1, 1}, 1};
    if (!add_grid(entry, entry.name, entry.mass, grid, [&](int i, int, int) {
          const bool fixed =
              (i == 0 && has(entry.fixed, "first")) || (i == entry.count - 1 && has(entry.fixed, "last"));
          return GridNode{entry.from + (i / (n - 1.0)) * (entry.to - entry.from), fixed};
        }))
      continue;
    attempt(entry, [&] {
      add_grid_springs(entry, grid, {1, 0, 0}, m);
      if (!(entry.bending_stiffness > 0.0)) return;
      for (std::size_t i = 0; i + 2 < grid.anchors.size(); ++i) {
        const std::vector<Anchor> over(grid.anchors.begin() + static_cast<long>(i),
                                       grid.anchors.begin() + static_cast<long>(i) + 3);
        const int id = builder_.add(CurvatureRow{
            {over[0].node, over[1].node, over[2].node}, entry.bending_stiffness, m.damping_time});
        rows_.push_back(
            {{scene_.nodes[static_cast<std::size_t>(grid.first) + i + 1].name, "curvature", 0, 3, over},
             id,
             &entry});
      }
    });
  }
}

void Assembly::add_cloths() {
  for (const ClothEntry& entry : document_.cloths) {
    if (!claim(entry, entry.name)) continue;
    names_[entry.name.value] = {};
    Material m;
    Grid grid;
    if (!material_of(entry, entry, -1.0, m) || !counts_of(entry, entry.count, 2, grid)) continue;
    const int nu = grid.count[0], nv = grid.count[1];
    const double nodes = static_cast<double>(nu) * nv;
    if (!require_counts(entry, nodes, 6.0 * nodes)) continue;
    if (!add_grid(entry, entry.name, entry.mass, grid, [&](int i, int j, int) {
          const bool u0 = i == 0, u1 = i == nu - 1, v0 = j == 0, v1 = j == nv - 1;
          const bool corner = (u0 && v0 && has(entry.fixed, "c00")) ||
                              (u1 && v0 && has(entry.fixed, "c10")) ||
                              (u0 && v1 && has(entry.fixed, "c01")) || (u1 && v1 && has(entry.fixed, "c11"));
          return GridNode{entry.corner + i * entry.edge_u / (nu - 1) + j * entry.edge_v / (nv - 1),
                          corner || on_side(entry.fixed, "u", i, nu) || on_side(entry.fixed, "v", j, nv)};
        }))
      continue;
    Material shear = m, bend = m;
    if (entry.shear_stiffness.given) shear.stiffness = entry.shear_stiffness.value;
    bend.stiffness = entry.bend_stiffness.given ? entry.bend_stiffness.value : 0.0;
    attempt(entry, [&] {
      for (const std::array<int, 3> step : {std::array{0, 1, 0}, std::array{1, 0, 0}})
        add_grid_springs(entry, grid, step, m);
      if (shear.stiffness > 0.0)
        for (const std::array<int, 3> step : {std::array{1, 1, 0}, std::array{1, -1, 0}})
          add_grid_springs(entry, grid, step, shear);
      if (bend.stiffness > 0.0)
        for (const std::array<int, 3> step : {std::array{0, 2, 0}, std::array{2, 0, 0}})
          add_grid_springs(entry, grid, step, bend);
    });
  }
}

void Assembly::add_lattices() {
  for (const LatticeEntry& entry : document_.lattices) {
    if (!claim(entry, entry.name)) continue;
    names_[entry.name.value] = {};
    Material m;
    Grid grid;
    if (!material_of(entry, entry, -1.0, m) || !counts_of(entry, entry.count, 3, grid)) continue;
    const auto [nx, ny, nz] = grid.count;
    const double nodes = static_cast<double>(nx) * ny * nz;
    if (!require_counts(entry, nodes, 13.0 * nodes)) continue;
    const Vector3d cell = entry.size.cwiseQuotient(Vector3d(nx - 1, ny - 1, nz - 1));
    if (!add_grid(entry, entry.name, entry.mass, grid, [&](int i, int j, int k) {
          return GridNode{entry.corner + cell.cwiseProduct(Vector3d(i, j, k)),
                          on_side(entry.fixed, "x", i, grid.count[0]) ||
                              on_side(entry.fixed, "y", j, grid.count[1]) ||
                              on_side(entry.fixed, "z", k, grid.count[2])};
        }))
      continue;
    attempt(entry, [&] {
      for (int i = 0; i <= 1; ++i)
        for (int j = -1; j <= 1; ++j)
          for (int k = -1; k <= 1; ++k)
            if (i > 0 || j > 0 || (j == 0 && k > 0)) add_grid_springs(entry, grid, {i, j, k}, m);
    });
  }
}

void Assembly::add_nets() {
  for (const NetEntry& entry : document_.nets) {
    if (!claim(entry, entry.name)) continue;
    names_[entry.name.value] = {};
    Material m;
    Grid grid;
    const bool sound = material_of(entry, entry, kRigid, m) && counts_of(entry, entry.count, 2, grid);
    if (!sound) continue;
    const int nx = grid.count[0], nz = grid.count[1];
    const double plates = static_cast<double>(nx) * nz;
    if (!require_counts(entry, 3.0 * plates, 6.0 * plates) || group(entry.name.value) < 0) continue;
    std::vector<int>& members = scene_.groups[static_cast<std::size_t>(group(entry.name.value))].members;
    const Vector3d edges(entry.edge, entry.thickness, entry.edge);
    auto centre = [&](double i, double j) {
      return Vector3d(entry.corner + entry.edge * Vector3d(i + 0.5, 0.0, j + 0.5));
    };
    attempt(entry, [&] {
      const MassProperties properties = solid_box(entry.label, entry.mass, edges);
      for (int i = 0; i < nx; ++i)
        for (int j = 0; j < nz; ++j) {
          const Anchor plate = add_body(properties, {.position = centre(i, j)});
          grid.anchors.push_back(plate);
          members.push_back(static_cast<int>(scene_.nodes.size()));
          name_node(entry, indexed(entry.name.value, {i, j, 0}, 2), SceneNode::Kind::kBody, plate, {});
          scene_.surfaces.push_back(box_surface(edges));
          scene_.surfaces.back().body = plate.body;
        }
      auto join = [&](const std::string& name, Anchor a, Anchor b, const Vector3d& place) {
        const std::vector<int> ids = add_ball(builder_, a, b, place, {.linear = m});
        const Anchor held = a.body >= 0 ? a : b, end = builder_.anchor_at(held, place);
        rows_.push_back(
            {{name, "ball", 0, 3, {end, b.body >= 0 ? builder_.anchor_at(b, place) : end}}, ids[0], &entry});
      };
      auto plate = [&](int i, int j) { return grid.anchors[static_cast<std::size_t>(grid.at(i, j, 0))]; };
      auto name = [&](int i, int j) { return indexed(entry.name.value, {i, j, 0}, 2); };
      for (int i = 0; i < nx; ++i)
        for (int j = 0; j < nz; ++j) {
          if (i + 1 < nx)
            join(name(i, j) + " - " + name(i + 1, j), plate(i, j), plate(i + 1, j), centre(i + 0.5, j));
          if (j + 1 < nz)
            join(name(i, j) + " - " + name(i, j + 1), plate(i, j), plate(i, j + 1), centre(i, j + 0.5));
          if (i == 0 && has(entry.fixed, "x0"))
            join("world x0 - " + name(i, j), {}, plate(i, j), centre(-0.5, j));
          if (i == nx - 1 && has(entry.fixed, "x1"))
            join(name(i, j) + " - world x1", plate(i, j), {}, centre(nx - 0.5, j));
          if (j == 0 && has(entry.fixed, "z0"))
            join("world z0 - " + name(i, j), {}, plate(i, j), centre(i, -0.5));
          if (j == nz - 1 && has(entry.fixed, "z1"))
            join(name(i, j) + " - world z1", plate(i, j), {}, centre(i, nz - 0.5));
        }
    });
  }
}

}  // namespace feder
