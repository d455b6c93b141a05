#include "models/catalog.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "engine/kkt.h"

namespace feder {
namespace {

std::vector<std::string> names() {
  std::vector<std::string> list;
  for (const ModelInfo& info : catalog()) list.push_back(info.name);
  return list;
}

class Catalog : public testing::TestWithParam<std::string> {
 protected:
  const Model model = make_model(GetParam());
  const ModelInfo& info() const {
    for (const ModelInfo& i : catalog())
      if (i.name == GetParam()) return i;
    throw std::logic_error("not in the catalogue");
  }
};

TEST_P(Catalog, BuildsAFiniteMovingScene) {
  EXPECT_EQ(model.name, GetParam());
  EXPECT_GT(model.system.free_count, 0);
  EXPECT_TRUE(model.system.active_rows > 0 || !model.system.bodies.empty() || model.system.fluid);
  EXPECT_EQ(model.state.q.size(), model.system.position_size());
  EXPECT_TRUE(model.state.q.allFinite() && model.state.v.allFinite());
  EXPECT_TRUE(std::isfinite(model.end_time) && model.end_time > 0.0);
  EXPECT_TRUE(std::isfinite(model.scene_length) && model.scene_length > 0.0);
}

TEST_P(Catalog, HasFiniteForcesThatMoveIt) {
  VectorXd f;
  const Status status = evaluate_forces(model.system, model.state, f);
  ASSERT_TRUE(status.ok()) << status.reason;
  add_gyroscopic_torques(model.system, model.state.v, f);
  EXPECT_TRUE(f.allFinite());
  EXPECT_GT(f.cwiseProduct(model.system.inverse_mass).norm(), 0.0);
}

TEST_P(Catalog, DescribesEveryParameter) {
  std::set<std::string> seen;
  EXPECT_FALSE(info().description.empty());
  for (const Parameter& p : info().parameters) {
    EXPECT_TRUE(seen.insert(p.name).second) << p.name;
    EXPECT_FALSE(p.what.empty() || p.default_value.empty() || p.expectation.empty()) << p.name;
  }
}

TEST_P(Catalog, AcceptsItsDefaultsAsText) {
  std::string spec = GetParam() + ":";
  for (const Parameter& p : info().parameters)
    spec += (spec.back() == ':' ? "" : ",") + p.name + "=" + p.default_value;
  const Model again = make_model(spec);
  EXPECT_TRUE(again.state.q == model.state.q);
  EXPECT_TRUE(again.system.stiffness == model.system.stiffness);
  EXPECT_EQ(again.end_time, model.end_time);
}

TEST_P(Catalog, SaysWhatItConservesUnlessDamped) {
  const bool damped = model.system.has_damping || model.system.forces.has_drag;
  if (damped || model.system.colliders.empty())  // contacts may leave nothing as it was
    EXPECT_EQ(model.conserved.empty(), damped);
}

INSTANTIATE_TEST_SUITE_P(Models, Catalog, testing::ValuesIn(names()), [](const auto& i) { return i.param; });

TEST(Spec, SettingsReachTheSystem) {
  const Model model = make_model("hanging_chain:n=7, stiffness=rigid ,gravity=0,drag=0.5");
  EXPECT_EQ(model.system.nodes, 8);
  EXPECT_TRUE(model.system.has_hard_rows);
  EXPECT_TRUE(model.system.forces.has_drag);
  EXPECT_EQ(model.system.forces.constant.norm(), 0.0);
}

TEST(Spec, PresetsTakeFurtherSettings) {
  const Model model = make_model("S4s(3):damping_time=1e-3");
  EXPECT_TRUE(model.system.has_damping);
  EXPECT_DOUBLE_EQ(model.system.stiffness.maxCoeff(), 1e4);
}

TEST(Spec, PresetsTakeAsManySizesAsTheyName) {
  const Model model = make_model("S3b( 6 , 2):gravity=0"), same = make_model("plate_bridge:nx=6,ny=2");
  EXPECT_TRUE(model.state.q == same.state.q);
  EXPECT_EQ(model.system.forces.gravity, Vector3d(0.0, 0.0, 0.0));
}

TEST(Spec, DampingIsOfferedOnEveryModelOfStabilityStudies) {
  for (const char* name : {"chain", "taut_string", "hanging_chain", "cloth", "lattice", "bending_rod"}) {
    const Model model = make_model(std::string(name) + ":damping_time=1e-4,drag=1e-3");
    EXPECT_TRUE(model.system.has_damping && model.system.forces.has_drag) << name;
    EXPECT_TRUE(model.conserved.empty()) << name;
  }
}

}  // namespace
}  // namespace feder
