#pragma once

#include <vector>

#include "engine/kernels.h"

namespace feder {

/// All distance rows (springs, rods), phi = |x_b - x_a| - rest, in the order the vector kernels read them.
///
/// Rows with equal node offset b - a and consecutive a form *runs*: their batch reads and writes 8
/// consecutive nodes instead of gathering. Gaps in a run and the end of the gathered rest are filled with
/// inactive slots (public_row -1, d = 0). Where x_a = x_b the direction is defined as 0: no force if rest =
/// 0, a reported degenerate row otherwise.
struct DistanceRows {
  std::vector<int> a, b;             ///< nodes
  std::vector<double> rest;          ///< rest length [m]
  std::vector<double> stiffness;     ///< d [N/m]; infinity is a rod
  std::vector<double> spring;        ///< d where finite, 0 for rods and inactive slots [N/m]
  std::vector<double> damping;       ///< b = d tau + own coefficient where d is finite [kg/s]
  std::vector<double> damping_time;  ///< tau [s]
  std::vector<int> public_row;       ///< row id given to the user, -1 for an inactive slot
  std::vector<int> run;              ///< per batch: first node of a run, -1 if it gathers
  bool has_damping = false;

  int size() const { return static_cast<int>(a.size()); }
  int batches() const { return static_cast<int>(run.size()); }
  bool active(int k) const { return public_row[k] >= 0 && (stiffness[k] > 0.0 || damping[k] > 0.0); }
};

/// One distance row as the user states it.
struct DistanceRow {
  int a = -1, b = -1;
  double rest = 0.0, stiffness = 0.0, damping_time = 0.0, damping = 0.0;
};

/// Sorts rows into batches for a system of `nodes` nodes. Row i gets public_row i.
DistanceRows arrange_distance_rows(const std::vector<DistanceRow>& rows, int nodes);

}  // namespace feder
