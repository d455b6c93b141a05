// What a scene says of hard rows that its start does not fit.
#include "models/scene_file/start_check.h"

#include <gtest/gtest.h>

#include "models/scene_file/scene_file.h"

namespace feder {
namespace {

SceneFile scene(const std::string& turn, const std::string& velocity) {
  return read_scene_text(R"(
end_time = 1
[[body]]
name = "bar"
shape = "box"
mass = 1
edges = [1, 0.1, 0.1]
position = [0.5, 0, 0]
angular_velocity = [0, 0, 2]
velocity = )" + velocity + R"(
[[joint]]
type = "hinge"
name = "pin"
between = ["world", "bar"]
place = [0, 0, 0]
axis = [0, 0, 1]
)" + turn,
                         "bar.toml", ".");
}

TEST(StartCheck, HasNothingToSayOfAStartThatFits) {
  EXPECT_TRUE(scene("", "[0, 1, 0]").notes.empty());
}

TEST(StartCheck, NotesAVelocityAcrossAPin) {
  const SceneFile file = scene("", "[0, 0.25, 0]");
  ASSERT_EQ(file.notes.size(), 1u);
  EXPECT_NE(file.notes[0].find("1 rigid row, row 'pin' (ball) the most (0.75 m/s"), std::string::npos)
      << file.notes[0];
}

TEST(StartCheck, RefusesARigidRowThatIsOpen) {
  const std::string motor =
      "[[turn]]\nbetween = [\"world\", \"bar\"]\naxis = [0, 0, 1]\nstiffness = \"rigid\"\ntarget = ";
  EXPECT_TRUE(scene(motor + "\"2*t\"\n", "[0, 1, 0]").notes.empty());
  try {
    scene(motor + "\"0.5 + 2*t\"\n", "[0, 1, 0]");
    FAIL() << "accepted";
  } catch (const SceneError& error) {
    EXPECT_STREQ(
        error.what(),
        "bar.toml:17:1: turn 0: this rigid turn is open by 0.5 rad at the start, expected 0: a length as "
        "placed, a target that starts at 0");
  }
}

TEST(StartCheck, GivesNoUnitToDirectionsThatAreNotPerpendicular) {
  try {
    scene(
        "[[perpendicular]]\nbetween = [\"world\", \"bar\"]\ndirection_a = [1, 0, 0]\ndirection_b = [0.6, "
        "0.8, 0]\n",
        "[0, 1, 0]");
    FAIL() << "accepted";
  } catch (const SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("is open by 0.6 at the start"), std::string::npos)
        << error.what();
  }
}

TEST(StartCheck, FindsOpenAndMovingRodsOfASystem) {
  SystemBuilder builder;
  const Anchor a = builder.add_world_point({0, 0, 0}), b = builder.add_particle(1.0, {2, 0, 0}, {0.5, 3, 0});
  builder.add_distance(a, b, {kRigid}, 1.5);
  const auto [system, state] = builder.build();
  ASSERT_EQ(open_rows(system, state).size(), 1u);
  EXPECT_DOUBLE_EQ(open_rows(system, state)[0].size, 0.5);
  ASSERT_EQ(moving_rows(system, state).size(), 1u);
  EXPECT_DOUBLE_EQ(moving_rows(system, state)[0].size, 0.5);
}

}  // namespace
}  // namespace feder
