#include "engine/geometry/broad_phase.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/check.h"
#include "engine/geometry/aabb.h"
#include "tests/support/campaign.h"
#include "tests/support/random.h"

namespace feder {
namespace {

using Pairs = std::vector<std::pair<int, int>>;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Sizes over six decades; some boxes are points, empty, equal, touching, or half spaces.
std::vector<Aabb> random_boxes(Random& random, int count) {
  std::vector<Aabb> boxes;
  for (int k = 0; k < count; ++k) {
    const Vector3d centre = random.vector();
    const Vector3d half = (random.vector() * std::pow(10.0, random.uniform(-6.0, 0.0))).cwiseAbs();
    Aabb box{centre - half, centre + half};
    const int kind = random.below(40), axis = random.below(3);
    if (kind == 0) box.max = box.min;
    if (kind == 1) std::swap(box.min[axis], box.max[axis]);
    if (kind == 2) box.max[axis] = kInfinity;
    if (kind == 3) box = {Vector3d::Constant(-kInfinity), {kInfinity, kInfinity, centre.z()}};
    if (kind == 4 && k > 0) box = boxes.back();
    if (kind == 5 && k > 0)
      box.min[axis] = boxes.back().max[axis], box.max[axis] = box.min[axis] + half[axis];
    boxes.push_back(box);
  }
  return boxes;
}

Pairs all_pairs(const std::vector<Aabb>& boxes) {
  Pairs out;
  for (int i = 0; i < static_cast<int>(boxes.size()); ++i)
    for (int j = i + 1; j < static_cast<int>(boxes.size()); ++j)
      if (!is_empty(boxes[i]) && !is_empty(boxes[j]) && overlap(boxes[i], boxes[j])) out.emplace_back(i, j);
  return out;
}

// Full campaign: 1000 sets of up to 400 boxes, ten updates each, some with another number of boxes.
TEST(BroadPhaseCampaign, PairsAreThoseOfAllPairsWhileBoxesMove) {
  std::size_t found = 0;
  for (int seed = 0; seed < test::campaign_cases(1000); ++seed) {
    SCOPED_TRACE(seed);
    Random random(static_cast<std::uint64_t>(seed));
    BroadPhase phase;
    std::vector<Aabb> boxes = random_boxes(random, random.below(400));
    Pairs pairs;
    for (int step = 0; step < 10; ++step) {
      phase.update(boxes);
      phase.find_pairs(pairs);
      ASSERT_EQ(pairs, all_pairs(boxes)) << "step " << step;
      found += pairs.size();
      const double speed = std::pow(10.0, random.uniform(-3.0, 0.0));
      for (Aabb& box : boxes) {
        const Vector3d move = random.vector(speed);
        box = {box.min + move, box.max + move};
      }
      if (random.below(4) == 0) boxes.push_back({Vector3d::Zero(), Vector3d::Ones()});
    }
  }
  EXPECT_GT(found, 1000u);
}

TEST(BroadPhaseCampaign, PairsOfTwoSetsAreThoseOfAllPairs) {
  for (int seed = 0; seed < test::campaign_cases(1000); ++seed) {
    SCOPED_TRACE(seed);
    Random random(static_cast<std::uint64_t>(seed));
    const std::vector<Aabb> a = random_boxes(random, random.below(30)),
                            b = random_boxes(random, random.below(300));
    Pairs expected, found;
    for (int i = 0; i < static_cast<int>(a.size()); ++i)
      for (int j = 0; j < static_cast<int>(b.size()); ++j)
        if (!is_empty(a[i]) && !is_empty(b[j]) && overlap(a[i], b[j])) expected.emplace_back(i, j);
    BroadPhase phase_a, phase_b;
    phase_a.update(a);
    phase_b.update(b);
    phase_a.find_pairs(phase_b, found);
    ASSERT_EQ(found, expected);
  }
}

TEST(BroadPhase, RefusesWhatIsNotANumber) {
  BroadPhase phase;
  EXPECT_THROW(phase.update({{Vector3d::Zero(), {1.0, std::nan(""), 1.0}}}), InputError);
}

TEST(BroadPhase, HugeBoxesAreKeptApartWithoutOverflow) {
  BroadPhase phase;
  Pairs pairs;
  const Vector3d low = Vector3d::Constant(-1e308), high = Vector3d::Constant(1e308);
  phase.update({{low, low}, {high, high}, {low, high}, {Vector3d::Zero(), Vector3d::Zero()}});
  phase.find_pairs(pairs);
  EXPECT_EQ(pairs, (Pairs{{0, 2}, {1, 2}, {2, 3}}));
}

}  // namespace
}  // namespace feder
