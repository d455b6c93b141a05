// The scenes the peers are measured on, with exactly their parameters.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "models/catalog.h"
#include "models/cloth.h"
#include "models/lattice.h"

namespace feder {
namespace {

struct Count {
  int springs = 0;
  std::multiset<double> stiffness;
};

Count count_springs(const System& s) {
  Count count;
  for (int k = 0; k < s.distance.size(); ++k)
    if (s.distance.active(k)) ++count.springs, count.stiffness.insert(s.distance.stiffness[k]);
  return count;
}

int fixed_nodes(const System& s) {
  int fixed = 0;
  for (FreeMask mask : s.free) fixed += mask == kPinned;
  return fixed;
}

TEST(SceneS1, HasTheParametersOfThePeers) {
  const Model model = make_model("S1(100)");
  const System& s = model.system;
  const Count count = count_springs(s);
  EXPECT_EQ(count.springs, 100);
  EXPECT_EQ(count.stiffness.count(1e6), 100u);
  EXPECT_EQ(fixed_nodes(s), 1);
  EXPECT_EQ(s.free_count, 300);
  for (int i = 1; i <= 100; ++i) EXPECT_EQ(s.mass[i], 0.01);
  EXPECT_DOUBLE_EQ(model.state.q[300], 1.0);
  EXPECT_EQ(s.forces.gravity, Vector3d(0.0, -9.81, 0.0));
  EXPECT_EQ(model.state.v.norm(), 0.0);
  EXPECT_DOUBLE_EQ(model.scene_length, 1.0);
  EXPECT_EQ(model.end_time, 0.25);
}

TEST(SceneS1h, IsS1WithRods) {
  const Model soft = make_model("S1(50)"), rigid = make_model("S1h(50)");
  EXPECT_FALSE(soft.system.has_hard_rows);
  EXPECT_TRUE(std::isinf(*count_springs(rigid.system).stiffness.begin()));
  EXPECT_EQ(rigid.system.active_rows, 50);
  EXPECT_TRUE(soft.state.q == rigid.state.q);
}

TEST(SceneS2, HasTheParametersOfThePeers) {
  const Model model = make_model("S2(20)");
  const System& s = model.system;
  const Count count = count_springs(s);
  EXPECT_EQ(count.springs, 2202);
  EXPECT_EQ(count.stiffness.count(1e5), 760u + 722u);
  EXPECT_EQ(count.stiffness.count(1e4), 720u);
  EXPECT_NEAR(s.mass.sum(), 1.0, 1e-14);
  EXPECT_EQ(fixed_nodes(s), 2);
  EXPECT_EQ(s.free[0], kPinned);
  EXPECT_EQ(s.free[19], kPinned);
  EXPECT_EQ(Vector3d(model.state.q.segment<3>(3 * 19)), Vector3d(0.0, 0.0, 1.0));
  EXPECT_EQ(Vector3d(model.state.q.tail<3>()), Vector3d(1.0, 0.0, 1.0));
  EXPECT_EQ(model.end_time, 0.25);
}

TEST(SceneS4, HasTheParametersOfThePeers) {
  const Model model = make_model("S4(10)");
  const System& s = model.system;
  const Count count = count_springs(s);
  EXPECT_EQ(count.springs, 10476);
  EXPECT_EQ(count.stiffness.count(200.0 / 9.0), 10476u);
  EXPECT_NEAR(s.mass.sum(), 1.0, 1e-12);
  EXPECT_EQ(fixed_nodes(s), 100);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(model.state.q[3 * i], 0.0);
  EXPECT_EQ(Vector3d(model.state.q.tail<3>()), Vector3d(1.0, 1.0, 1.0));
  EXPECT_EQ(model.end_time, 0.25);
}

TEST(SceneS4s, IsS4AHundredTimesStiffer) {
  const Count soft = count_springs(make_model("S4(5)").system),
              stiff = count_springs(make_model("S4s(5)").system);
  EXPECT_EQ(soft.springs, stiff.springs);
  EXPECT_DOUBLE_EQ(*stiff.stiffness.begin(), 100.0 * *soft.stiffness.begin());
}

TEST(Scenes, SpringsFollowTheClosedFormulas) {
  for (int n : {2, 3, 7}) {
    const std::string size = std::to_string(n) + ")";
    EXPECT_EQ(count_springs(make_model("S2(" + size).system).springs, cloth_springs(n)) << n;
    EXPECT_EQ(count_springs(make_model("S4(" + size).system).springs, lattice_springs(n)) << n;
  }
}

TEST(SceneS4, InnerNodesHave26Neighbours) {
  const System s = make_model("S4(4)").system;
  const int inner = (1 * 4 + 1) * 4 + 2;
  std::set<int> neighbours;
  for (int k = 0; k < s.distance.size(); ++k) {
    if (!s.distance.active(k)) continue;
    if (s.distance.a[k] == inner) neighbours.insert(s.distance.b[k]);
    if (s.distance.b[k] == inner) neighbours.insert(s.distance.a[k]);
  }
  EXPECT_EQ(neighbours.size(), 26u);
}

TEST(Scenes, NodesAreNumberedSoThatRowsFormRuns) {
  for (const char* spec : {"S1(1000)", "S2(50)", "S4(10)"}) {
    const DistanceRows rows = make_model(spec).system.distance;
    int runs = 0;
    for (int first : rows.run) runs += first >= 0;
    EXPECT_GT(runs, 0.8 * rows.batches()) << spec;  // 0.989 (S4)
  }
}

}  // namespace
}  // namespace feder
