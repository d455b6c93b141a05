#include "models/scene_file/scene_of.h"

#include <utility>

namespace feder {
namespace {

std::vector<SceneNode> nodes_of(const System& s) {
  std::vector<bool> is_dial(s.nodes);
  for (const Drive& drive : s.drives) is_dial[drive.node] = drive.dial;
  std::vector<SceneNode> nodes;
  const int bodies = static_cast<int>(s.bodies.size());
  for (int i = 0; i < s.places() - bodies; ++i)
    if (!is_dial[i])
      nodes.push_back({"node " + std::to_string(i),
                       s.mass[i] > 0.0 ? SceneNode::Kind::kParticle : SceneNode::Kind::kPoint, i, -1});
  for (int i = 0; i < bodies; ++i)
    nodes.push_back({"body " + std::to_string(i), SceneNode::Kind::kBody, s.bodies[i].centre, i});
  return nodes;
}

/// What lies at each first row; entries of other rows stay without nodes.
std::vector<SceneRow> rows_by_first_row(const System& s) {
  std::vector<SceneRow> rows(s.rows);
  for (int k = 0; k < s.distance.size(); ++k)
    rows[k] = {"", "distance", k, 1, {{s.distance.a[k]}, {s.distance.b[k]}}};
  int first = s.distance.size();
  for_each_stencil_row_type(s.stencil_rows, [&](const auto& list) {
    for (const auto& row : list) {
      SceneRow entry{"", row.kName, first, row.kRows, {}};
      if constexpr (requires { row.a; })
        entry.nodes = {row.a, row.b};
      else
        for (const int node : row.nodes) entry.nodes.push_back({node});
      rows[first] = std::move(entry);
      first += row.kRows;
    }
  });
  return rows;
}

}  // namespace

Scene scene_of(Model model) {
  Scene scene;
  const System& s = model.system;
  scene.nodes = nodes_of(s);
  std::vector<SceneRow> rows = rows_by_first_row(s);
  for (const int first : s.row_of_id) {
    scene.rows.push_back(std::move(rows[first]));
    scene.rows.back().name = s.row_name(first);
  }
  scene.model = std::move(model);
  return scene;
}

}  // namespace feder
