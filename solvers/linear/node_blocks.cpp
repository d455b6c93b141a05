// A distance row adds H = (w - g) u u^T + g E at (a,a) and (b,b) and -H at (a,b), with w = 1/gamma and g its
// geometric coefficient. The diagonal blocks are summed in a compact array and written once; the off-diagonal
// ones go straight to their place.
#include "solvers/linear/node_blocks.h"

#include <algorithm>

namespace feder {
namespace {

// the upper triangle of H, as 6 numbers
struct Symmetric3 {
  double xx, xy, xz, yy, yz, zz;
};

Symmetric3 row_block(const double* u, double w, double g) {
  const double s = w - g, x = s * u[0], y = s * u[1], z = s * u[2];
  return {x * u[0] + g, x * u[1], x * u[2], y * u[1] + g, y * u[2], z * u[2] + g};
}

void add6(double* d, const Symmetric3& h) {
  d[0] += h.xx, d[1] += h.xy, d[2] += h.xz, d[3] += h.yy, d[4] += h.yz, d[5] += h.zz;
}

}  // namespace

void NodeBlocks::analyze(const System& s, const std::vector<int>& unknown, const SymmetricPattern& pattern) {
  *this = {};
  system_ = &s;
  diagonal_.assign(6 * s.nodes, 0.0);
  diagonal_entry_.assign(6 * s.nodes, -1);
  for (int i = 0; i < s.nodes; ++i)
    for (int r = 0, at = 6 * i; r < 3; ++r)
      for (int c = r; c < 3; ++c, ++at)
        diagonal_entry_[at] = pattern.slot(unknown[3 * i + r], unknown[3 * i + c]);

  for (int k = 0; k < s.distance.size(); ++k) {
    if (!s.distance.active(k)) continue;
    const int a = s.distance.a[k], b = s.distance.b[k];
    if (s.free[a] == kFree && s.free[b] == kFree) {
      const int high = unknown[3 * a] > unknown[3 * b] ? a : b, low = high == a ? b : a;
      const int column = pattern.upper ? high : low, row = pattern.upper ? low : high;
      WholeRow whole{k, a, b, {}};
      for (int c = 0; c < 3; ++c) whole.column[c] = pattern.slot(unknown[3 * row], unknown[3 * column + c]);
      whole_.push_back(whole);
    } else {
      PartRow part{k, a, b, {}};
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
          part.entry[3 * r + c] = pattern.slot(unknown[3 * a + r], unknown[3 * b + c]);
      part_.push_back(part);
    }
  }

  for (const Stencil& stencil : s.stencils) {
    const int size = 3 * stencil.nodes;
    stencil_scratch_.resize(std::max<std::size_t>(stencil_scratch_.size(), size * size));
    auto coordinate = [&](int i) { return unknown[3 * s.stencil_nodes[stencil.first_node + i / 3] + i % 3]; };
    for (int i = 0; i < size; ++i)
      for (int j = 0; j < size; ++j)
        stencil_entry_.push_back(j <= i ? pattern.slot(coordinate(i), coordinate(j)) : -1);
  }
}

void NodeBlocks::add(const Kkt& kkt, bool with_rows, std::vector<double>& values) {
  std::fill(diagonal_.begin(), diagonal_.end(), 0.0);
  const double* u = kkt.u.data();
  const bool rows_matter = with_rows || kkt.geometric;
  auto coefficients = [&](int k) {
    return std::pair{with_rows ? kkt.inverse_gamma[k] : 0.0, kkt.geometric ? kkt.geometric_distance[k] : 0.0};
  };
  for (const WholeRow& row : whole_) {
    if (!rows_matter) break;
    const auto [w, g] = coefficients(row.row);
    const Symmetric3 h = row_block(u + 3 * row.row, w, g);
    add6(diagonal_.data() + 6 * row.a, h);
    add6(diagonal_.data() + 6 * row.b, h);
    double *x = values.data() + row.column[0], *y = values.data() + row.column[1],
           *z = values.data() + row.column[2];
    x[0] -= h.xx, x[1] -= h.xy, x[2] -= h.xz;
    y[0] -= h.xy, y[1] -= h.yy, y[2] -= h.yz;
    z[0] -= h.xz, z[1] -= h.yz, z[2] -= h.zz;
  }
  for (const PartRow& row : part_) {
    if (!rows_matter) break;
    const auto [w, g] = coefficients(row.row);
    const Symmetric3 h = row_block(u + 3 * row.row, w, g);
    add6(diagonal_.data() + 6 * row.a, h);
    add6(diagonal_.data() + 6 * row.b, h);
    const double full[9] = {h.xx, h.xy, h.xz, h.xy, h.yy, h.yz, h.xz, h.yz, h.zz};
    for (int i = 0; i < 9; ++i)
      if (row.entry[i] >= 0) values[row.entry[i]] -= full[i];
  }
  for (int i = 0; i < system_->nodes; ++i) {
    double* d = diagonal_.data() + 6 * i;
    d[0] += kkt.mass[3 * i], d[3] += kkt.mass[3 * i + 1], d[5] += kkt.mass[3 * i + 2];
    for (int e = 0; e < 6; ++e)
      if (diagonal_entry_[6 * i + e] >= 0) values[diagonal_entry_[6 * i + e]] += d[e];
  }
  if (rows_matter) add_stencils(kkt, with_rows, values);
}

void NodeBlocks::add_stencils(const Kkt& kkt, bool with_rows, std::vector<double>& values) {
  const int* entry = stencil_entry_.data();
  for (const Stencil& stencil : system_->stencils) {
    const int size = 3 * stencil.nodes;
    double* K = stencil_scratch_.data();
    if (kkt.geometric)
      std::copy_n(kkt.geometric_stencil.data() + stencil.matrix, size * size, K);
    else
      std::fill_n(K, size * size, 0.0);
    // J^T gamma^-1 J, row by row
    for (int row = 0; with_rows && row < stencil.rows; ++row) {
      const double* J = kkt.jacobian.data() + stencil.jacobian + row * size;
      const double w = kkt.inverse_gamma[stencil.first_row + row];
      for (int i = 0; i < size; ++i)
        for (int j = 0; j <= i; ++j) K[i * size + j] += w * J[i] * J[j];
    }
    for (int i = 0; i < size; ++i)
      for (int j = 0; j <= i; ++j)
        if (entry[i * size + j] >= 0) values[entry[i * size + j]] += K[i * size + j];
    entry += size * size;
  }
}

}  // namespace feder
