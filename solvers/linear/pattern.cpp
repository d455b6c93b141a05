#include "solvers/linear/pattern.h"

#include <algorithm>

#include "engine/check.h"

namespace feder {

int SymmetricPattern::slot(int i, int j) const {
  if (i < 0 || j < 0) return -1;
  const int column = upper ? std::max(i, j) : std::min(i, j),
            wanted = upper ? std::min(i, j) : std::max(i, j);
  const auto begin = row.begin() + column_start[column], end = row.begin() + column_start[column + 1];
  const auto found = std::lower_bound(begin, end, wanted);
  FEDER_CHECK(found != end && *found == wanted, "entry outside the analysed pattern");
  return static_cast<int>(found - row.begin());
}

SymmetricPattern SymmetricPattern::flipped() const {
  SymmetricPattern out;
  out.size = size;
  out.upper = !upper;
  out.column_start.assign(size + 1, 0);
  out.row.resize(row.size());
  for (int r : row) ++out.column_start[r + 1];
  for (int j = 0; j < size; ++j) out.column_start[j + 1] += out.column_start[j];
  std::vector<int> next(out.column_start.begin(), out.column_start.end() - 1);
  for (int j = 0; j < size; ++j)
    for (int at = column_start[j]; at < column_start[j + 1]; ++at) out.row[next[row[at]]++] = j;
  return out;
}

SymmetricPattern make_pattern(int size, std::vector<std::pair<int, int>> entries) {
  for (auto& [i, j] : entries)
    if (i < j) std::swap(i, j);  // lower: row i >= column j
  for (int i = 0; i < size; ++i) entries.emplace_back(i, i);
  std::sort(entries.begin(), entries.end(), [](const auto& x, const auto& y) {
    return x.second != y.second ? x.second < y.second : x.first < y.first;
  });
  entries.erase(std::unique(entries.begin(), entries.end()), entries.end());
  SymmetricPattern out;
  out.size = size;
  out.column_start.assign(size + 1, 0);
  out.row.reserve(entries.size());
  for (const auto& [i, j] : entries) {
    ++out.column_start[j + 1];
    out.row.push_back(i);
  }
  for (int j = 0; j < size; ++j) out.column_start[j + 1] += out.column_start[j];
  return out;
}

std::vector<Incidence> incidences(const System& s) {
  std::vector<Incidence> out;
  for (int k = 0; k < s.distance.size(); ++k) {
    if (!s.distance.active(k)) continue;
    if (s.free[s.distance.a[k]]) out.push_back({k, s.distance.a[k], 3 * k, true, -1.0});
    if (s.free[s.distance.b[k]]) out.push_back({k, s.distance.b[k], 3 * k, true, 1.0});
  }
  for (const Stencil& stencil : s.stencils)
    for (int i = 0; i < stencil.rows; ++i)
      for (int j = 0; j < stencil.nodes; ++j) {
        const int node = s.stencil_nodes[stencil.first_node + j], row = stencil.first_row + i;
        if (s.free[node] && s.active(row))
          out.push_back({row, node, stencil.jacobian + 3 * (i * stencil.nodes + j), false, 1.0});
      }
  return out;
}

std::vector<std::pair<int, int>> coupled_nodes(const System& s) {
  std::vector<std::pair<int, int>> out;
  auto couple = [&](int i, int j) {
    if (i != j && s.free[i] && s.free[j]) out.emplace_back(std::min(i, j), std::max(i, j));
  };
  for (int k = 0; k < s.distance.size(); ++k)
    if (s.distance.active(k)) couple(s.distance.a[k], s.distance.b[k]);
  for (const Stencil& stencil : s.stencils)
    for (int i = 0; i < stencil.nodes; ++i)
      for (int j = 0; j < i; ++j)
        couple(s.stencil_nodes[stencil.first_node + i], s.stencil_nodes[stencil.first_node + j]);
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

}  // namespace feder
