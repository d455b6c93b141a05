#include "solvers/linear/numbering.h"

#include "solvers/linear/cholmod_factor.h"
#include "solvers/linear/pattern.h"

namespace feder {

Numbering number_free_coordinates(const System& s) {
  // order the graph of nodes that can move, then expand every node by its free coordinates
  std::vector<int> vertex(s.nodes, -1), node;
  for (int i = 0; i < s.nodes; ++i)
    if (s.free[i]) {
      vertex[i] = static_cast<int>(node.size());
      node.push_back(i);
    }
  std::vector<std::pair<int, int>> edges = coupled_nodes(s);
  for (auto& [i, j] : edges) i = vertex[i], j = vertex[j];
  const Ordering ordering = fill_reducing_order(static_cast<int>(node.size()), edges, 3);

  Numbering out;
  out.ordering = ordering.name;
  out.unknown.assign(3 * s.nodes, -1);
  for (int v : ordering.order)
    for (int c = 0; c < 3; ++c)
      if (s.free[node[v]] >> c & 1) {
        out.unknown[3 * node[v] + c] = static_cast<int>(out.coordinate.size());
        out.coordinate.push_back(3 * node[v] + c);
      }
  return out;
}

}  // namespace feder
