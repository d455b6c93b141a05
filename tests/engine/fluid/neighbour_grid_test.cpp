// The grid finds exactly the pairs that comparing all with all finds.
#include "engine/fluid/neighbour_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/check.h"
#include "tests/support/random.h"

namespace feder {
namespace {

using Pairs = std::vector<std::pair<int, int>>;

bool near(const std::vector<double>& x, int dimension, int i, int j, double support) {
  double squared = 0.0;
  for (int c = 0; c < dimension; ++c)
    squared += (x[dimension * i + c] - x[dimension * j + c]) * (x[dimension * i + c] - x[dimension * j + c]);
  return squared < support * support;
}

Pairs by_grid(NeighbourGrid& grid, const std::vector<double>& x, int dimension, double support,
              long* looked = nullptr) {
  grid.sort(x.data(), static_cast<int>(x.size()) / dimension, dimension, support);
  Pairs pairs;
  auto look = [&](int a, int b) {
    if (looked) ++*looked;
    const int i = grid.order()[a], j = grid.order()[b];
    if (near(x, dimension, i, j, support)) pairs.emplace_back(std::min(i, j), std::max(i, j));
  };
  grid.for_each_cell(
      [&](NeighbourGrid::Range cell, int row_end, const NeighbourGrid::Range* ahead, int count) {
        for (int i = cell.first; i < cell.last; ++i) {
          for (int j = i + 1; j < row_end; ++j) look(i, j);
          for (int row = 0; row < count; ++row)
            for (int j = ahead[row].first; j < ahead[row].last; ++j) look(i, j);
        }
      });
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

Pairs by_comparison(const std::vector<double>& x, int dimension, double support) {
  Pairs pairs;
  const int points = static_cast<int>(x.size()) / dimension;
  for (int i = 0; i < points; ++i)
    for (int j = i + 1; j < points; ++j)
      if (near(x, dimension, i, j, support)) pairs.emplace_back(i, j);
  return pairs;
}

enum Cloud { kEven, kClustered, kFarAway, kOnBorders, kScattered, kCoincident, kClouds };

std::vector<double> make_cloud(Random& random, int kind, int dimension, int points, double support) {
  std::vector<double> x(dimension * points);
  const double size = support * random.uniform(1.0, 6.0), shift = kind == kFarAway ? -3.7e5 * support : 0.0;
  for (int i = 0; i < points; ++i) {
    double spread = size;
    if (kind == kClustered) spread = i % 3 ? 0.3 * support : 40.0 * support;
    if (kind == kScattered) spread = i % 5 ? size : 1e12 * support;
    for (int c = 0; c < dimension; ++c) {
      double& at = x[dimension * i + c];
      at = shift + random.uniform(-spread, spread);
      if (kind == kOnBorders) at = support * (random.below(9) - 4);
      if (kind == kCoincident && i % 2) at = x[c];
    }
  }
  return x;
}

TEST(NeighbourGrid, FindsWhatComparingAllWithAllFinds) {
  Random random(5);
  NeighbourGrid grid;  // reused: nothing of the last cloud may stay
  long found = 0;
  for (int round = 0; round < 3000; ++round) {
    const int dimension = 1 + round % 3, kind = round / 3 % kClouds,
              points = random.below(round % 7 ? 60 : 200);
    const double support = std::exp(random.uniform(-5.0, 5.0));
    const std::vector<double> x = make_cloud(random, kind, dimension, points, support);
    const Pairs pairs = by_grid(grid, x, dimension, support);
    ASSERT_EQ(pairs, by_comparison(x, dimension, support)) << "round " << round;
    found += static_cast<long>(pairs.size());
  }
  EXPECT_GT(found, 100000);
}

TEST(NeighbourGrid, SeesNoPairTwiceAndKeepsTheOrderWithinACell) {
  Random random(6);
  std::vector<double> x;
  for (int i = 0; i < 600; ++i) x.push_back(random.uniform(0.0, 4.0));
  NeighbourGrid grid, other;
  const Pairs pairs = by_grid(grid, x, 3, 1.0);
  EXPECT_GT(pairs.size(), 100u);
  EXPECT_EQ(std::adjacent_find(pairs.begin(), pairs.end()), pairs.end());
  std::vector<double> moved(x.size(), 0.25);
  (void)by_grid(other, moved, 3, 0.1);
  EXPECT_TRUE(std::is_sorted(other.order().begin(), other.order().end()));
  (void)by_grid(other, x, 3, 1.0);
  EXPECT_EQ(other.order(), grid.order());
}

// Candidates per point stay bounded where a few points lie 10^12 supports away.
TEST(NeighbourGrid, StrayPointsDoNotMergeTheCellsOfTheOthers) {
  Random random(7);
  std::vector<double> x;
  for (int i = 0; i < 3 * 4000; ++i) x.push_back(random.uniform(0.0, 16.0));
  long looked = 0, with_strays = 0;
  NeighbourGrid grid;
  (void)by_grid(grid, x, 3, 1.0, &looked);
  for (int i = 0; i < 30; ++i) x.push_back((i % 2 ? 1.0 : -1.0) * 1e12 * (1 + i));
  (void)by_grid(grid, x, 3, 1.0, &with_strays);
  EXPECT_GT(looked, 4000);
  EXPECT_LT(static_cast<double>(with_strays), 1.1 * static_cast<double>(looked));  // cells lie otherwise
}

TEST(NeighbourGrid, TakesNoPointsAndRefusesNonsense) {
  NeighbourGrid grid;
  const std::vector<double> none;
  EXPECT_TRUE(by_grid(grid, none, 2, 1.0).empty());
  EXPECT_TRUE(by_grid(grid, {1.0, 2.0, 3.0}, 3, 1.0).empty());
  EXPECT_THROW(grid.sort(none.data(), 0, 4, 1.0), MisuseError);
  EXPECT_THROW(grid.sort(none.data(), 0, 3, 0.0), MisuseError);
}

}  // namespace
}  // namespace feder
