#include "models/scene_file/scene_of.h"

#include <gtest/gtest.h>

#include <set>

#include "models/catalog.h"

namespace feder {
namespace {

TEST(SceneOf, NamesEveryPlaceOfEveryModelOnce) {
  for (const ModelInfo& info : catalog()) {
    const Scene scene = scene_of(info.build({}));
    const System& s = scene.model.system;
    std::set<std::string> names;
    for (const SceneNode& node : scene.nodes) names.insert(node.name);
    const auto dials = static_cast<std::size_t>(
        std::count_if(s.drives.begin(), s.drives.end(), [](const Drive& drive) { return drive.dial; }));
    EXPECT_EQ(names.size(), scene.nodes.size()) << info.name;
    EXPECT_EQ(scene.nodes.size() + dials, static_cast<std::size_t>(s.places())) << info.name;
  }
}

TEST(SceneOf, ShowsEveryRowThatIsNoPaddingOnce) {
  for (const ModelInfo& info : catalog()) {
    const Scene scene = scene_of(info.build({}));
    const System& s = scene.model.system;
    std::vector<int> shown(s.rows, 0);
    for (const SceneRow& row : scene.rows)
      for (int i = 0; i < row.rows; ++i) ++shown[row.first_row + i];
    for (int k = 0; k < s.rows; ++k) {
      const bool padding = k < s.distance.size() && s.distance.public_row[k] < 0;
      EXPECT_EQ(shown[k], padding ? 0 : 1) << info.name << " row " << k;
    }
  }
}

TEST(SceneOf, KnowsWhatEachEntryOfAMechanismIs) {
  SystemBuilder builder;
  const Anchor point = builder.add_world_point({0.0, 0.0, 0.0});
  const Anchor particle = builder.add_particle(1.0, {1.0, 0.0, 0.0});
  const Anchor body = builder.add_body(solid_box("box", 1.0, {1.0, 1.0, 1.0}), {.position = {3.0, 0.0, 0.0}});
  BallRow ball;
  ball.a = particle;
  ball.b = {.body = body.body, .point = {-2.0, 0.0, 0.0}};
  ball.stiffness = 5.0;
  builder.add(ball);
  builder.add_distance(point, particle, {10.0});
  auto [system, state] = builder.build();
  const Scene scene = scene_of({.name = "three", .system = system, .state = state});

  ASSERT_EQ(scene.nodes.size(), 3u);
  EXPECT_EQ(scene.nodes[0].kind, SceneNode::Kind::kPoint);
  EXPECT_EQ(scene.nodes[1].name, "node 1");
  EXPECT_EQ(scene.nodes[1].kind, SceneNode::Kind::kParticle);
  EXPECT_EQ(scene.nodes[2].name, "body 0");
  EXPECT_EQ(scene.nodes[2].body, 0);
  ASSERT_EQ(scene.rows.size(), 2u);
  EXPECT_EQ(scene.rows[0].name, "ball row 0 (node 1, body 0)");
  EXPECT_EQ(scene.rows[0].type, "ball");
  EXPECT_EQ(scene.rows[0].rows, 3);
  EXPECT_EQ(scene.rows[0].nodes[1].point, Vector3d(-2.0, 0.0, 0.0));
  EXPECT_EQ(scene.rows[1].name, "distance row 1 (nodes 0, 1)");
}

}  // namespace
}  // namespace feder
