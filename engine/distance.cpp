#include "engine/distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace feder {
namespace {

// A run batch with fewer rows than this is cheaper as part of a gathered batch.
constexpr int kLeastRun = 4;

void append_slot(DistanceRows& out, const DistanceRow& row, int public_row) {
  const bool soft = std::isfinite(row.stiffness);
  out.a.push_back(row.a);
  out.b.push_back(row.b);
  out.rest.push_back(row.rest);
  out.stiffness.push_back(row.stiffness);
  out.spring.push_back(soft ? row.stiffness : 0.0);
  out.damping.push_back(soft ? row.stiffness * row.damping_time + row.damping : 0.0);
  out.damping_time.push_back(row.damping_time);
  out.public_row.push_back(public_row);
  out.has_damping = out.has_damping || out.damping.back() > 0.0;
}

void append_run(DistanceRows& out, const std::vector<DistanceRow>& rows, int first, int offset,
                const std::array<int, kBatch>& lanes) {
  out.run.push_back(first);
  for (int lane = 0; lane < kBatch; ++lane) {
    if (lanes[lane] >= 0)
      append_slot(out, rows[lanes[lane]], lanes[lane]);
    else
      append_slot(out, {first + lane, first + lane + offset, 0.0, 0.0, 0.0}, -1);
  }
}

}  // namespace

DistanceRows arrange_distance_rows(const std::vector<DistanceRow>& input, int nodes) {
  std::vector<DistanceRow> rows = input;
  for (DistanceRow& row : rows)
    if (row.a > row.b) std::swap(row.a, row.b);  // phi is symmetric in its ends
  std::vector<int> order(rows.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int i, int j) {
    const int offset_i = rows[i].b - rows[i].a, offset_j = rows[j].b - rows[j].a;
    return offset_i != offset_j ? offset_i < offset_j : rows[i].a < rows[j].a;
  });

  DistanceRows out;
  std::vector<int> gathered;
  for (std::size_t next = 0; next < order.size();) {
    // window of 8 consecutive nodes a, shifted down where b would run past the last node
    const DistanceRow& head = rows[order[next]];
    const int offset = head.b - head.a;
    const int first = std::min(head.a, nodes - offset - kBatch);
    std::array<int, kBatch> lanes;
    lanes.fill(-1);
    std::vector<int> doubled;
    int found = 0;
    std::size_t end = next;
    for (; end < order.size(); ++end) {
      const DistanceRow& row = rows[order[end]];
      const int lane = row.a - first;
      if (row.b - row.a != offset || lane >= kBatch) break;
      if (first < 0 || lanes[lane] >= 0)
        doubled.push_back(order[end]);
      else
        lanes[lane] = order[end], ++found;
    }
    if (found >= kLeastRun && first >= 0)
      append_run(out, rows, first, offset, lanes);
    else
      for (int lane : lanes)
        if (lane >= 0) gathered.push_back(lane);
    gathered.insert(gathered.end(), doubled.begin(), doubled.end());
    next = end;
  }

  std::sort(gathered.begin(), gathered.end());
  for (std::size_t i = 0; i < gathered.size(); ++i) {
    if (i % kBatch == 0) out.run.push_back(-1);
    append_slot(out, rows[gathered[i]], gathered[i]);
  }
  while (out.size() % kBatch != 0) append_slot(out, {0, nodes - 1, 0.0, 0.0, 0.0}, -1);
  return out;
}

}  // namespace feder
