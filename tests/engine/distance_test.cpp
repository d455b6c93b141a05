// How distance rows are sorted into batches of 8 (distance.h).
#include "engine/distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "tests/engine/arrangement.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace feder {
namespace {

/// Springs to the right and upper neighbour of a width x height grid, numbered row by row.
std::vector<DistanceRow> grid_rows(int width, int height) {
  std::vector<DistanceRow> rows;
  for (int i = 0; i < width * height; ++i) {
    if (i % width + 1 < width) rows.push_back({i, i + 1, 1.0, 10.0, 0.0});
    if (i + width < width * height) rows.push_back({i, i + width, 1.0, 20.0, 0.1});
  }
  return rows;
}

int runs_in(const DistanceRows& rows) {
  return static_cast<int>(
      std::count_if(rows.run.begin(), rows.run.end(), [](int first) { return first >= 0; }));
}

TEST(DistanceRows, GridIsMostlyRunsAndKeepsEveryRow) {
  const std::vector<DistanceRow> rows = grid_rows(30, 20);
  const DistanceRows arranged = arrange_distance_rows(rows, 600);
  EXPECT_EQ(arrangement_fault(arranged, rows, 600), "");
  EXPECT_GT(runs_in(arranged), arranged.batches() * 9 / 10);  // 146 of 147
}

TEST(DistanceRows, RandomNetGathersAndKeepsEveryRow) {
  Random random(5);
  std::vector<DistanceRow> rows;
  for (int i = 0; i < 500; ++i) {
    const int a = random.below(300), b = (a + 1 + random.below(299)) % 300;
    rows.push_back({a, b, random.uniform(0.0, 2.0), random.uniform(0.0, 9.0), random.uniform(0.0, 0.1)});
  }
  const DistanceRows arranged = arrange_distance_rows(rows, 300);
  EXPECT_EQ(arrangement_fault(arranged, rows, 300), "");
  EXPECT_LT(runs_in(arranged), arranged.batches() / 10);  // 0 of 63
}

TEST(DistanceRows, ShuffledGridKeepsEveryRow) {
  Random random(6);
  std::vector<int> name(600);
  for (int i = 0; i < 600; ++i) name[i] = i;
  for (int i = 599; i > 0; --i) std::swap(name[i], name[random.below(i + 1)]);
  std::vector<DistanceRow> rows = grid_rows(30, 20);
  for (DistanceRow& row : rows) row.a = name[row.a], row.b = name[row.b];
  for (int i = static_cast<int>(rows.size()) - 1; i > 0; --i) std::swap(rows[i], rows[random.below(i + 1)]);
  EXPECT_EQ(arrangement_fault(arrange_distance_rows(rows, 600), rows, 600), "");
}

TEST(DistanceRows, DoubledRowsAreKeptBothTimesInBothDirections) {
  std::vector<DistanceRow> rows = grid_rows(12, 1);
  ASSERT_EQ(rows.size(), 11u);
  for (int i = 0; i < 11; ++i)
    rows.push_back({i + 1, i, 0.5, 3.0, 0.0});  // the same pairs, stated the other way round
  rows.push_back(rows.front());
  EXPECT_EQ(arrangement_fault(arrange_distance_rows(rows, 12), rows, 12), "");
}

TEST(DistanceRows, NoRowsGiveNoBatches) {
  const DistanceRows arranged = arrange_distance_rows({}, 5);
  EXPECT_EQ(arranged.size(), 0);
  EXPECT_EQ(arranged.batches(), 0);
  EXPECT_FALSE(arranged.has_damping);
}

TEST(DistanceRows, ChainsOfEveryShortLengthKeepEveryRow) {
  int runs = 0;
  for (int nodes = 2; nodes <= 40; ++nodes) {
    const std::vector<DistanceRow> rows = grid_rows(nodes, 1);
    const DistanceRows arranged = arrange_distance_rows(rows, nodes);
    EXPECT_EQ(arrangement_fault(arranged, rows, nodes), "") << nodes;
    runs += runs_in(arranged);
  }
  EXPECT_GT(runs, 0);  // 97
}

TEST(DistanceRows, LastWindowMovesDownInsteadOfReadingPastTheLastNode) {
  const std::vector<DistanceRow> rows =
      grid_rows(14, 1);  // 13 rows: a window at 0, the next would start at 8 and end at 16
  const DistanceRows arranged = arrange_distance_rows(rows, 14);
  ASSERT_EQ(runs_in(arranged), 2);
  EXPECT_EQ(arranged.run[1], 5);
  EXPECT_EQ(arrangement_fault(arranged, rows, 14), "");
}

TEST(DistanceRows, RodsAndSlotsPullNothingInTheForceKernels) {
  std::vector<DistanceRow> rows = grid_rows(9, 1);
  rows[3].stiffness = kRigid;
  rows[3].damping_time = 0.5;
  const DistanceRows arranged = arrange_distance_rows(rows, 9);
  int rods = 0, slots = 0;
  for (int k = 0; k < arranged.size(); ++k) {
    if (arranged.public_row[k] == 3) {
      ++rods;
      EXPECT_TRUE(arranged.active(k));
      EXPECT_EQ(arranged.stiffness[k], kRigid);
      EXPECT_EQ(arranged.spring[k], 0.0);
      EXPECT_EQ(arranged.damping[k], 0.0);
      EXPECT_EQ(arranged.damping_time[k], 0.5);
    } else if (arranged.public_row[k] < 0) {
      ++slots;
      EXPECT_FALSE(arranged.active(k));
      EXPECT_EQ(arranged.spring[k], 0.0);
    }
  }
  EXPECT_EQ(rods, 1);
  EXPECT_EQ(slots, arranged.size() - 8);
}

TEST(DistanceRows, DampingIsStiffnessTimesDampingTime) {
  const DistanceRows none = arrange_distance_rows({{0, 1, 1.0, 40.0, 0.0}}, 2);
  EXPECT_FALSE(none.has_damping);
  const DistanceRows some = arrange_distance_rows({{0, 1, 1.0, 40.0, 0.25}}, 2);
  EXPECT_TRUE(some.has_damping);
  EXPECT_EQ(some.damping[0], 10.0);
}

}  // namespace
}  // namespace feder
