// Scenes that must be refused, each with everything the reader says about it.
#include "tests/experiments/wrong_scenes.h"

#include <gtest/gtest.h>

namespace feder::experiments {
namespace {

TEST(WrongScenes, EachIsRefusedWithAllItsProblemsAndTheirPlaces) {
  const std::vector<WrongScene> scenes = wrong_scenes();
  ASSERT_GE(scenes.size(), 350u);
  for (const WrongScene& scene : scenes) {
    SCOPED_TRACE(scene.where);
    const std::vector<std::string> problems = problems_of(scene.text, scene.changes);
    ASSERT_FALSE(scene.problems.empty());
    ASSERT_EQ(problems.size(), scene.problems.size()) << (problems.empty() ? "accepted" : problems.back());
    for (std::size_t i = 0; i < problems.size(); ++i) EXPECT_EQ(problems[i], scene.problems[i]);
  }
}

}  // namespace
}  // namespace feder::experiments
