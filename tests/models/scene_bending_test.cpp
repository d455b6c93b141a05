#include <gtest/gtest.h>

#include "models/scene_file/scene_file.h"

namespace feder {
namespace {

// Three particles in a line, a material and a [[bending]] over them.
SceneFile bending_scene(const std::string& material, const std::string& bending) {
  std::string text = "end_time = 1\n[[material]]\nname = \"m\"\nstiffness = 2\n" + material + "\n";
  for (const char* particle :
       {"a\"\nposition = [0, 0, 0]", "b\"\nposition = [1, 0, 0]", "c\"\nposition = [2, 0, 0]"})
    text += "[[particle]]\nmass = 1\nname = \"" + std::string(particle) + "\n";
  return read_scene_text(text + "[[bending]]\nover = [\"a\", \"b\", \"c\"]\n" + bending, "s.toml", ".");
}

std::string refusal(const std::string& material, const std::string& bending) {
  try {
    bending_scene(material, bending);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(SceneBending, TakesStiffnessAndDampingTimeOfItsMaterial) {
  const SceneFile file = bending_scene("damping_time = 0.5", "material = \"m\"");
  ASSERT_EQ(file.scene.rows.size(), 1u);
  EXPECT_EQ(file.scene.rows[0].type, "curvature");
  EXPECT_TRUE(file.scene.model.system.has_damping);
}

TEST(SceneBending, RefusesADampingItWouldNotHave) {
  EXPECT_NE(refusal("", "stiffness = 1\ndamping = 2").find("no key 'damping'"), std::string::npos);
  EXPECT_NE(refusal("damping = 2", "material = \"m\"")
                .find("s.toml:20:12: bending 0: material = 'm' has a damping"),
            std::string::npos)
      << refusal("damping = 2", "material = \"m\"");
}

}  // namespace
}  // namespace feder
