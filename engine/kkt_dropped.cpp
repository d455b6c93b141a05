// Hard rows taken out of the matrix because they depend on others: their J and phi change places with zeros.
#include <algorithm>
#include <cmath>

#include "engine/kkt.h"

namespace feder {
namespace {

constexpr int kMostColumns = 15;  // of a row: 5 nodes

const Stencil& stencil_of(const System& s, int row) {
  return *std::prev(std::upper_bound(s.stencils.begin(), s.stencils.end(), row,
                                     [](int k, const Stencil& stencil) { return k < stencil.first_row; }));
}

}  // namespace

// Numbers of a row in u or in the pool, their count in `size`.
double* Kkt::jacobian_of(int row, int& size) {
  size = 3;
  if (row < system->distance.size()) return u.data() + 3 * row;
  const Stencil& stencil = stencil_of(*system, row);
  size = 3 * stencil.nodes;
  return jacobian.data() + stencil.jacobian + (row - stencil.first_row) * size;
}

void Kkt::swap_dropped() {
  double* kept = dropped_jacobian_.data();
  for (std::size_t i = 0; i < dropped_.size(); ++i, kept += kMostColumns) {
    int size = 0;
    double* J = jacobian_of(dropped_[i], size);
    std::swap_ranges(J, J + size, kept);
    std::swap(phi[dropped_[i]], dropped_phi_[static_cast<Eigen::Index>(i)]);
  }
}

void Kkt::drop_rows(const std::vector<int>& rows) {
  swap_dropped();  // the old ones come back
  for (int k : dropped_) gamma[k] = 0.0;
  dropped_ = rows;
  for (int k : dropped_) gamma[k] = 1.0, r[k] = 0.0;
  dropped_phi_ = VectorXd::Zero(static_cast<Eigen::Index>(rows.size()));
  dropped_jacobian_ = VectorXd::Zero(static_cast<Eigen::Index>(rows.size()) * kMostColumns);
  swap_dropped();
  ++step_serial_;
}

double Kkt::dropped_gap() const {
  return dropped_.empty() ? 0.0 : dropped_phi_.cwiseAbs().maxCoeff();
}

double Kkt::kept_gap() const {
  double largest = 0.0;
  for (int k = 0; k < phi.size(); ++k)
    if (gamma[k] == 0.0) largest = std::max(largest, std::abs(phi[k]));
  return largest;
}

std::pair<int, double> Kkt::dropped_gap_after(const VectorXd& w) const {
  const System& s = *system;
  std::pair<int, double> worst{-1, 0.0};
  for (std::size_t i = 0; i < dropped_.size(); ++i) {
    const double* J = dropped_jacobian_.data() + i * kMostColumns;
    const int row = dropped_[i];
    double gap = dropped_phi_[static_cast<Eigen::Index>(i)];
    if (row < s.distance.size()) {
      for (int c = 0; c < 3; ++c) gap += J[c] * (w[3 * s.distance.b[row] + c] - w[3 * s.distance.a[row] + c]);
    } else {
      const Stencil& stencil = stencil_of(s, row);
      for (int j = 0; j < 3 * stencil.nodes; ++j)
        gap += J[j] * w[3 * s.stencil_nodes[stencil.first_node + j / 3] + j % 3];
    }
    if (worst.first < 0 || std::abs(gap) > worst.second) worst = {row, std::abs(gap)};
  }
  return worst;
}

}  // namespace feder
