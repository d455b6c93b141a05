// What every arrangement of distance rows promises, as one checker.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "engine/distance.h"

namespace feder {

/// Empty if `arranged` holds every row of `input` exactly once and its batches are as documented; otherwise
/// the first fault.
inline std::string arrangement_fault(const DistanceRows& arranged, const std::vector<DistanceRow>& input,
                                     int nodes) {
  const std::size_t slots = arranged.a.size();
  auto at = [](int k) { return " at slot " + std::to_string(k); };
  for (std::size_t size :
       {arranged.b.size(), arranged.rest.size(), arranged.stiffness.size(), arranged.spring.size(),
        arranged.damping.size(), arranged.damping_time.size(), arranged.public_row.size()})
    if (size != slots) return "arrays of different length";
  if (slots != kBatch * arranged.run.size()) return "slots are not 8 per batch";

  std::vector<int> seen(input.size(), 0);
  for (int k = 0; k < arranged.size(); ++k) {
    const int a = arranged.a[k], b = arranged.b[k], id = arranged.public_row[k];
    if (a < 0 || a >= nodes || b < 0 || b >= nodes) return "node out of range" + at(k);
    if (id < 0) {
      if (id != -1 || arranged.stiffness[k] != 0.0 || arranged.spring[k] != 0.0 ||
          arranged.damping[k] != 0.0 || arranged.active(k))
        return "padding that acts" + at(k);
      continue;
    }
    if (id >= static_cast<int>(input.size())) return "unknown row" + at(k);
    ++seen[id];
    const DistanceRow& row = input[id];
    if (std::minmax(a, b) != std::minmax(row.a, row.b)) return "other nodes" + at(k);
    const bool soft = std::isfinite(row.stiffness);
    if (arranged.rest[k] != row.rest || arranged.stiffness[k] != row.stiffness ||
        arranged.damping_time[k] != row.damping_time || arranged.spring[k] != (soft ? row.stiffness : 0.0) ||
        arranged.damping[k] != (soft ? row.stiffness * row.damping_time : 0.0))
      return "other numbers" + at(k);
    if (arranged.active(k) != (row.stiffness > 0.0)) return "wrong activity" + at(k);
  }
  for (std::size_t id = 0; id < seen.size(); ++id)
    if (seen[id] != 1) return "row " + std::to_string(id) + " occurs " + std::to_string(seen[id]) + " times";

  for (int batch = 0; batch < arranged.batches(); ++batch) {
    const int first = arranged.run[batch], head = kBatch * batch;
    if (first < -1) return "run before node 0";
    if (first < 0) continue;
    const int offset = arranged.b[head] - arranged.a[head];
    if (offset <= 0) return "run with offset <= 0" + at(head);
    for (int lane = 0; lane < kBatch; ++lane)
      if (arranged.a[head + lane] != first + lane || arranged.b[head + lane] != first + lane + offset)
        return "run that is not consecutive" + at(head + lane);
  }
  return "";
}

}  // namespace feder
