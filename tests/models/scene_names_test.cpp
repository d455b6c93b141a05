// Rows of generators: results tell them apart by name and type.
#include <gtest/gtest.h>

#include <set>

#include "models/scene_file/scene_file.h"

namespace feder {
namespace {

TEST(SceneNames, TellEveryRowOfEveryGeneratorApart) {
  const SceneFile file = read_scene_text(R"(
end_time = 1
[[net]]
name = "net"
count = [1, 2]
edge = 0.2
thickness = 0.02
mass = 1
fixed = ["x0", "x1", "z0", "z1"]
[[cloth]]
name = "cloth"
edge_u = [1, 0, 0]
edge_v = [0, 1, 0]
count = [3, 4]
mass = 1
stiffness = 10
bend_stiffness = 1
[[lattice]]
name = "block"
size = [1, 1, 1]
count = [2, 3, 2]
mass = 1
stiffness = 10
[[chain]]
name = "chain"
from = [0, 0, 0]
to = [1, 0, 0]
count = 4
mass = 1
stiffness = 10
bending_stiffness = 1
)",
                                         "names.toml", ".");
  std::set<std::pair<std::string, std::string>> seen;
  for (const SceneRow& row : file.scene.rows)
    EXPECT_TRUE(seen.emplace(row.name, row.type).second) << row.name << " (" << row.type << ")";
  EXPECT_EQ(seen.count({"world x0 - net[0,0]", "ball"}), 1u);
  EXPECT_GT(seen.size(), 60u);
}

}  // namespace
}  // namespace feder
