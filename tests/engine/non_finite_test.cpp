// Degenerate rows and states that are not finite: reported by name, never a silent NaN (traps.md, classes 3
// and 8).
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "engine/kkt.h"
#include "tests/support/kernel_choice.h"
#include "tests/support/scenes.h"

namespace feder {
namespace {

struct Outcome {
  Status evaluate, forces, undamped;
  VectorXd u, phi, f;
};

Outcome outcome_of(const TestScene& scene) {
  Kkt kkt;
  kkt.prepare(scene.system);
  kkt.set_step(0.01, 0.1);
  Outcome out;
  out.evaluate = kkt.evaluate(scene.state.q);
  out.undamped = evaluate_undamped_forces(scene.system, scene.state, out.f);
  out.forces = evaluate_forces(scene.system, scene.state, out.f);
  out.u = kkt.u;
  out.phi = kkt.phi;
  return out;
}

void expect_failure(const Status& status, StatusCode code, const std::string& part,
                    const std::string& where) {
  EXPECT_TRUE(status.code == code && status.reason.find(part) != std::string::npos)
      << where << ": expected " << to_string(code) << " naming \"" << part << "\", found "
      << to_string(status.code) << " \"" << status.reason << '"';
}

/// A chain of 20 nodes (runs of 8) with a few long springs (gathered).
TestScene chain_and_net() {
  SystemBuilder builder;
  for (int i = 0; i < 20; ++i) builder.add_particle(1.0, {1.0 * i, 0.1 * (i % 3), 0.0}, {0.0, 0.0, 0.1 * i});
  for (int i = 0; i < 19; ++i) builder.add_distance({i}, {i + 1}, {10.0, 0.1}, 0.8);
  for (int i = 0; i < 3; ++i) builder.add_distance({2 * i}, {15 - i}, {10.0}, 3.0);
  auto [system, state] = builder.build();
  return {std::move(system), std::move(state)};
}

class DegenerateRow : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (!choice.available()) GTEST_SKIP() << "this processor has no " << GetParam();
  }
  KernelChoice choice{GetParam()};
};

TEST_P(DegenerateRow, CoincidentPointsAreReportedWithTheRowsName) {
  for (int i = 0; i < 19; ++i) {
    TestScene scene = chain_and_net();
    scene.state.q.segment<3>(3 * i) = scene.state.q.segment<3>(3 * i + 3);
    const std::string name = "distance row " + std::to_string(i) + " (nodes " + std::to_string(i) + ", " +
                             std::to_string(i + 1) + ")";
    const Outcome out = outcome_of(scene);
    expect_failure(out.evaluate, StatusCode::kSingular, name, "evaluate");
    expect_failure(out.forces, StatusCode::kSingular, name, "forces");
    expect_failure(out.undamped, StatusCode::kSingular, name, "undamped forces");
    EXPECT_TRUE(out.u.allFinite() && out.phi.allFinite() && out.f.allFinite());
  }
}

TEST_P(DegenerateRow, CoincidentPointsWithoutARowAreNoFault) {
  TestScene scene = chain_and_net();
  scene.state.q.segment<3>(3 * 3) = scene.state.q.segment<3>(3 * 17);
  scene.state.q.segment<3>(0) = scene.state.q.segment<3>(3 * 19);  // the nodes of the padding
  const Outcome out = outcome_of(scene);
  EXPECT_TRUE(out.evaluate.ok() && out.forces.ok() && out.undamped.ok()) << out.evaluate.reason;
  EXPECT_TRUE(out.u.allFinite() && out.phi.allFinite() && out.f.allFinite());
}

TEST_P(DegenerateRow, ZeroRestLengthAtZeroLengthIsNoFault) {
  SystemBuilder builder;
  for (int i = 0; i < 12; ++i) builder.add_particle(1.0, {0, 0, 0}, {1.0 * i, 0, 0});
  for (int i = 0; i < 11; ++i) builder.add_distance({i}, {i + 1}, {10.0, 0.2}, 0.0);
  auto [system, state] = builder.build();
  const Outcome out = outcome_of({std::move(system), std::move(state)});
  EXPECT_TRUE(out.evaluate.ok() && out.forces.ok() && out.undamped.ok()) << out.evaluate.reason;
  EXPECT_TRUE(out.u.isZero(0.0) && out.phi.isZero(0.0) && out.f.isZero(0.0));
}

TEST_P(DegenerateRow, SwitchedOffRowsAreNeverDegenerate) {
  SystemBuilder builder;
  for (int i = 0; i < 3; ++i) builder.add_particle(1.0, {0, 0, 0});
  builder.add_distance({0}, {1}, {0.0}, 1.0);
  builder.add(CurvatureRow{{0, 1, 2}, 0.0, 0.0});
  builder.add(AngleRow{{0, 1, 2}, 0.0, 0.0, 1.0});
  auto [system, state] = builder.build();
  const Outcome out = outcome_of({std::move(system), std::move(state)});
  EXPECT_TRUE(out.evaluate.ok() && out.forces.ok() && out.undamped.ok()) << out.evaluate.reason;
  EXPECT_TRUE(out.phi.isZero(0.0) && out.f.isZero(0.0));
}

TEST_P(DegenerateRow, FoldedCurvatureAndStraightAngleAreReportedByName) {
  for (bool curvature : {true, false}) {
    SystemBuilder builder;
    builder.add_particle(1.0, {0, 0, 0});
    builder.add_particle(1.0, {1, 0, 0});
    builder.add_particle(1.0, {curvature ? 0.5 : 2.0, 0, 0});
    builder.add_distance({0}, {1}, {1.0});
    if (curvature)
      builder.add(CurvatureRow{{0, 1, 2}, 3.0, 0.0});
    else
      builder.add(AngleRow{{0, 1, 2}, 3.0, 0.0, 1.0});
    auto [system, state] = builder.build();
    const Outcome out = outcome_of({std::move(system), std::move(state)});
    const std::string name = std::string(curvature ? "curvature" : "angle") + " row 1 (nodes 0, 1, 2)";
    expect_failure(out.evaluate, StatusCode::kSingular, name, "evaluate");
    expect_failure(out.forces, StatusCode::kSingular, name, "forces");
    EXPECT_TRUE(out.phi.allFinite() && out.f.allFinite());
  }
}

/// "nodes 3, 4" names node 3, and node 4.
bool names_node(const std::string& reason, int node) {
  const std::string text = std::to_string(node);
  return reason.find("nodes " + text + ",") != std::string::npos ||
         reason.find(", " + text + ")") != std::string::npos;
}

TEST_P(DegenerateRow, PositionsThatAreNotFiniteAreReportedWithARowThatHoldsThem) {
  for (double bad : {std::nan(""), kRigid, -kRigid}) {
    int reported = 0;
    for (int i = 0; i < 20; ++i) {
      TestScene scene = chain_and_net();
      scene.state.q[3 * i + i % 3] = bad;
      const Outcome out = outcome_of(scene);
      for (const Status& status : {out.evaluate, out.forces, out.undamped})
        reported += status.code == StatusCode::kNonFinite && names_node(status.reason, i);
    }
    EXPECT_EQ(reported, 3 * 20) << bad;
  }
}

TEST_P(DegenerateRow, LengthsThatOverflowAreReported) {
  TestScene scene = chain_and_net();
  scene.state.q[3 * 19] = 1e200;
  expect_failure(outcome_of(scene).evaluate, StatusCode::kNonFinite, "nodes 18, 19", "evaluate");
}

TEST_P(DegenerateRow, PositionsThatAreNotFiniteAreReportedWithABendingRowThatHoldsThem) {
  for (double bad : {std::nan(""), kRigid})
    for (bool curvature : {true, false}) {
      SystemBuilder builder;
      for (int i = 0; i < 3; ++i) builder.add_particle(1.0, {1.0 * i, 0.2 * i * i, 0});
      if (curvature)
        builder.add(CurvatureRow{{0, 1, 2}, 3.0, 0.0});
      else
        builder.add(AngleRow{{0, 1, 2}, 3.0, 0.0, 1.0});
      auto [system, state] = builder.build();
      state.q[4] = bad;
      const Outcome out = outcome_of({std::move(system), std::move(state)});
      expect_failure(out.evaluate, StatusCode::kNonFinite, "row 0 (nodes 0, 1, 2)", std::to_string(bad));
      expect_failure(out.forces, StatusCode::kNonFinite, "row 0 (nodes 0, 1, 2)", std::to_string(bad));
    }
}

TEST_P(DegenerateRow, ANodeWithoutRowsDoesNotSpoilOthersThroughThePadding) {
  // a run with gaps: its inactive slots touch nodes no row holds
  SystemBuilder builder;
  for (int i = 0; i < 16; ++i) builder.add_particle(1.0, {1.0 * i, 0.1 * (i % 3), 0.0});
  for (int i : {0, 1, 2, 4, 6})
    builder.add_distance({i}, {i + 1}, {10.0}, 0.8);  // node 9 .. 15 and 4-5 hang free
  auto [system, state] = builder.build();
  state.q[3 * 8] = std::nan("");
  const Outcome out = outcome_of({std::move(system), std::move(state)});
  const bool reported = out.forces.code == StatusCode::kNonFinite;
  EXPECT_TRUE(reported || out.f.allFinite())
      << "NaN at node 8 became forces elsewhere, status " << to_string(out.forces.code);
}

TEST_P(DegenerateRow, VelocitiesThatAreNotFiniteMakeDampedForcesThatShowIt) {
  TestScene scene = chain_and_net();
  scene.state.v[3 * 7] = std::nan("");
  const Outcome out = outcome_of(scene);
  EXPECT_TRUE(!out.forces.ok() || !out.f.allFinite());
}

INSTANTIATE_TEST_SUITE_P(Widths, DegenerateRow, testing::ValuesIn(kernel_names()),
                         [](const auto& instance) { return instance.param; });

}  // namespace
}  // namespace feder
