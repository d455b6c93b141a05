#include "engine/geometry/triangle_mesh.h"

#include <gtest/gtest.h>

namespace feder {
namespace {

TEST(TriangleMesh, IsEmptyAtFirst) {
  EXPECT_TRUE(TriangleMesh{}.triangles.empty());
}

}  // namespace
}  // namespace feder
