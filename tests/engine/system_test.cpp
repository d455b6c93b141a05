// What SystemBuilder refuses, and what it builds.
#include "engine/system.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <initializer_list>
#include <limits>
#include <set>
#include <string>

#include "engine/kkt.h"
#include "tests/support/scenes.h"

namespace feder {
namespace {

const double kNan = std::numeric_limits<double>::quiet_NaN();

/// Runs `action`, which must throw InputError, and looks for every part in its message.
void expect_refused(std::initializer_list<const char*> parts, const std::function<void()>& action) {
  try {
    action();
    ADD_FAILURE() << "accepted; expected a message with " << *parts.begin();
  } catch (const InputError& error) {
    const std::string text = error.what();
    for (const char* part : parts)
      EXPECT_NE(text.find(part), std::string::npos) << "no \"" << part << "\" in: " << text;
  }
}

/// Four particles on the x axis.
SystemBuilder four() {
  SystemBuilder builder;
  for (int i = 0; i < 4; ++i) builder.add_particle(1.0, {1.0 * i, 0, 0});
  return builder;
}

TEST(SystemBuilder, RefusesEveryMassThatIsNotFiniteAndPositive) {
  SystemBuilder builder = four();
  expect_refused({"node 4", "mass = nan kg"}, [&] { builder.add_particle(kNan, {0, 0, 0}); });
  expect_refused({"node 4", "mass = inf kg"}, [&] { builder.add_particle(kRigid, {0, 0, 0}); });
  expect_refused({"node 4", "mass = 0 kg"}, [&] { builder.add_particle(0.0, {0, 0, 0}); });
  expect_refused({"node 4", "mass = -2.5 kg"}, [&] { builder.add_particle(-2.5, {0, 0, 0}); });
}

TEST(SystemBuilder, RefusesPositionsAndVelocitiesThatAreNotFinite) {
  for (int c = 0; c < 3; ++c) {
    SystemBuilder builder = four();
    expect_refused({"node 4", "position = nan m"},
                   [&] { builder.add_particle(1.0, kNan * Vector3d::Unit(c)); });
    Vector3d bad = Vector3d::Zero();
    bad[c] = -kRigid;
    expect_refused({"node 4", "position = -inf m"}, [&] { builder.add_particle(1.0, bad); });
    expect_refused({"node 4", "velocity = -inf m/s"}, [&] { builder.add_particle(1.0, {0, 0, 0}, bad); });
    expect_refused({"node 4", "position = -inf m"}, [&] { builder.add_world_point(bad); });
  }
}

TEST(SystemBuilder, RefusesVelocityAlongAMaskedCoordinate) {
  SystemBuilder builder = four();
  expect_refused({"node 4", "velocity = 0.25 m/s", "masked"}, [&] {
    builder.add_particle(1.0, {0, 0, 0}, {1, 1, 0.25}, kPlanarXY);
  });
  EXPECT_NO_THROW(builder.add_particle(1.0, {0, 0, 0}, {1, 1, 0}, kPlanarXY));
}

TEST(SystemBuilder, RefusesAMaskThatIsNone) {
  SystemBuilder builder = four();
  expect_refused({"node 4", "free mask = 8"}, [&] { builder.add_particle(1.0, {0, 0, 0}, {0, 0, 0}, 8); });
}

TEST(SystemBuilder, RefusesUnknownNodes) {
  SystemBuilder builder = four();
  builder.add_distance({0}, {1}, {1.0});
  expect_refused({"row 1 (distance)", "node = 4", "0 to 3"}, [&] { builder.add_distance({0}, {4}, {1.0}); });
  expect_refused({"row 1 (distance)", "node = -1"}, [&] { builder.add_distance(Anchor{}, {2}, {1.0}); });
  expect_refused({"row 1 (curvature)", "node = 9"}, [&] { builder.add(CurvatureRow{{0, 9, 2}, 1.0, 0.0}); });
  expect_refused({"row 1 (angle)", "node = -3"}, [&] { builder.add(AngleRow{{0, 1, -3}, 1.0, 0.0, 1.0}); });
  expect_refused({"constant force", "node = 4"}, [&] { builder.add_constant_force({4}, {1, 0, 0}); });
  builder.set_user_force(quartic_bond(1, 7, 1.0));
  expect_refused({"user force", "node = 7"}, [&] { (void)builder.build(); });
}

TEST(SystemBuilder, RefusesRowsThatHoldTheSameNodeTwice) {
  SystemBuilder builder = four();
  expect_refused({"row 0 (distance)", "node = 2"}, [&] { builder.add_distance({2}, {2}, {1.0}); });
  expect_refused({"row 0 (curvature)", "node = 1"}, [&] { builder.add(CurvatureRow{{1, 2, 1}, 1.0, 0.0}); });
  expect_refused({"row 0 (angle)", "node = 3"}, [&] { builder.add(AngleRow{{0, 3, 3}, 1.0, 0.0, 1.0}); });
}

TEST(SystemBuilder, RefusesNegativeAndNanStiffnessAndDamping) {
  SystemBuilder builder = four();
  expect_refused({"row 0 (distance)", "stiffness = -1 N/m"}, [&] { builder.add_distance({0}, {1}, {-1.0}); });
  expect_refused({"row 0 (distance)", "stiffness = nan N/m"},
                 [&] { builder.add_distance({0}, {1}, {kNan}); });
  expect_refused({"row 0 (distance)", "stiffness = -inf N/m"},
                 [&] { builder.add_distance({0}, {1}, {-kRigid}); });
  expect_refused({"row 0 (distance)", "damping time = nan s"}, [&] {
    builder.add_distance({0}, {1}, {1.0, kNan});
  });
  expect_refused({"row 0 (distance)", "damping time = -0.5 s"}, [&] {
    builder.add_distance({0}, {1}, {1.0, -0.5});
  });
  expect_refused({"row 0 (distance)", "damping time = inf s"}, [&] {
    builder.add_distance({0}, {1}, {1.0, kRigid});
  });
  expect_refused({"row 0 (curvature)", "stiffness = -2 N m"}, [&] {
    builder.add(CurvatureRow{{0, 1, 2}, -2.0, 0.0});
  });
  expect_refused({"row 0 (angle)", "stiffness = nan N m"}, [&] {
    builder.add(AngleRow{{0, 1, 2}, kNan, 0.0, 1.0});
  });
  expect_refused({"row 0 (angle)", "damping time = -1 s"}, [&] {
    builder.add(AngleRow{{0, 1, 2}, 1.0, -1.0, 1.0});
  });
}

TEST(SystemBuilder, RefusesARigidCurvatureRowBecauseItsRowsAreDependent) {
  SystemBuilder builder = four();
  expect_refused({"row 0 (curvature)", "stiffness = inf N m", "no rigid form"}, [&] {
    builder.add(CurvatureRow{{0, 1, 2}, kRigid, 0.0});
  });
  EXPECT_NO_THROW(builder.add(AngleRow{{0, 1, 2}, kRigid, 0.0, 1.0}));
}

TEST(SystemBuilder, RefusesARestLengthThatIsNotFinite) {
  SystemBuilder builder = four();
  expect_refused({"row 0 (distance)", "rest length = nan m"},
                 [&] { builder.add_distance({0}, {1}, {1.0}, kNan); });
  expect_refused({"row 0 (distance)", "rest length = inf m"},
                 [&] { builder.add_distance({0}, {1}, {1.0}, kRigid); });
}

TEST(SystemBuilder, RefusesARestLengthAsPlacedThatOverflows) {
  SystemBuilder builder;
  builder.add_particle(1.0, {-1e200, 0, 0});
  builder.add_particle(1.0, {1e200, 0, 0});
  expect_refused({"row 0 (distance)", "rest length = inf m"}, [&] { builder.add_distance({0}, {1}, {1.0}); });
}

TEST(SystemBuilder, RefusesARodOfLengthZeroBecauseItHasNoDirection) {
  SystemBuilder builder;
  builder.add_particle(1.0, {0, 0, 0});
  builder.add_particle(1.0, {0, 0, 0});
  expect_refused({"row 0 (distance)", "rest length = 0 m"},
                 [&] { builder.add_distance({0}, {1}, {kRigid}, 0.0); });
  expect_refused({"row 0 (distance)", "rest length = 0 m"},
                 [&] { builder.add_distance({0}, {1}, {kRigid}); });
}

TEST(SystemBuilder, RefusesARestAngleOutsideZeroToPi) {
  SystemBuilder builder = four();
  for (double bad : {0.0, -0.5, 3.2, kNan, kRigid})
    expect_refused({"row 0 (angle)", "rest angle = "}, [&] {
      builder.add(AngleRow{{0, 1, 2}, 1.0, 0.0, bad});
    });
  expect_refused({"3.2000000000000002 rad", "(0, pi)"}, [&] {
    builder.add(AngleRow{{0, 1, 2}, 1.0, 0.0, 3.2});
  });
}

TEST(SystemBuilder, RefusesForcesThatAreNotFiniteAndNegativeDrag) {
  SystemBuilder builder = four();
  expect_refused({"constant force on node 2", "force = nan N"}, [&] {
    builder.add_constant_force({2}, {0, kNan, 0});
  });
  builder.set_gravity({0, 0, kNan});
  expect_refused({"system", "gravity = nan m/s^2"}, [&] { (void)builder.build(); });
  builder.set_gravity({0, 0, 0});
  for (double bad : {-0.1, kNan, kRigid}) {
    builder.set_drag(bad);
    expect_refused({"system", "drag = "}, [&] { (void)builder.build(); });
  }
  builder.set_drag(-0.25);
  expect_refused({"drag = -0.25 kg/s"}, [&] { (void)builder.build(); });
}

TEST(SystemBuilder, RefusesAnEmptySystem) {
  expect_refused({"system", "no nodes"}, [] { (void)SystemBuilder{}.build(); });
}

TEST(SystemBuilder, IsUnchangedByWhatItRefuses) {
  SystemBuilder builder = four();
  EXPECT_THROW(builder.add_particle(-1.0, {0, 0, 0}), InputError);
  EXPECT_THROW(builder.add_distance({0}, {1}, {kNan}), InputError);
  EXPECT_THROW(builder.add(AngleRow{{0, 1, 2}, 1.0, 0.0, 4.0}), InputError);
  EXPECT_EQ(builder.add_distance({0}, {1}, {1.0}), 0);
  const auto [system, state] = builder.build();
  EXPECT_EQ(system.nodes, 4);
  EXPECT_EQ(system.active_rows, 1);
}

TEST(SystemBuilder, TakesTheRestLengthFromThePlacedNodesIfNoneIsGiven) {
  SystemBuilder builder;
  builder.add_particle(1.0, {0, 0, 0});
  builder.add_particle(1.0, {3, 4, 0});
  const int id = builder.add_distance({1}, {0}, {1.0});
  const auto [system, state] = builder.build();
  EXPECT_EQ(system.distance.rest[system.row_of_id[id]], 5.0);
}

TEST(System, MaskedCoordinatesHaveNoInverseMassAndNoForce) {
  const TestScene scene = mixed_scene(1);
  const System& s = scene.system;
  EXPECT_EQ(s.masked.size(), 3u + 2u + 1u);  // world point, rail, plane
  EXPECT_EQ(s.free_count, 36 - 6);
  for (int i : s.masked) {
    EXPECT_EQ(s.inverse_mass[i], 0.0);
    EXPECT_EQ(s.forces.constant[i], 0.0);
    EXPECT_EQ(s.forces.drag[i], 0.0);
  }
  for (int i = 0; i < 36; ++i)
    if (s.inverse_mass[i] > 0.0) {
      EXPECT_DOUBLE_EQ(s.inverse_mass[i] * s.mass[i / 3], 1.0);
      EXPECT_EQ(s.inertia[i], s.mass[i / 3]);
      EXPECT_EQ(s.forces.drag[i], 0.4);
    }
}

TEST(System, GravityAndConstantForcesAddUp) {
  const TestScene scene = mixed_scene(1);
  const System& s = scene.system;
  const Vector3d weight = s.mass[5] * Vector3d(0.1, -9.81, 0.3);
  EXPECT_TRUE(Vector3d(s.forces.constant.segment<3>(15)).isApprox(weight + Vector3d(1, 2, 3), 1e-15));
  EXPECT_NEAR(s.forces.constant[21], s.mass[7] * 0.1 + 0.5, 1e-15);
}

TEST(System, PublicRowIdsSurviveTheReordering) {
  // distance and bending rows mixed, so that ids, batches and row order all differ
  Random random(4);
  SystemBuilder builder;
  for (int i = 0; i < 30; ++i) builder.add_particle(1.0, Vector3d(i, 0, 0) + random.vector(0.3));
  std::vector<double> stiffness;
  std::vector<std::string> kind;
  for (int k = 0; k < 80; ++k) {
    const int i = random.below(30), j = (i + 1 + random.below(28)) % 30,
              l = (j + 1) % 30 == i ? (j + 2) % 30 : (j + 1) % 30;
    stiffness.push_back(1.0 + k);
    const int type = k % 4 == 3 ? 3 : random.below(3);
    int id = -1;
    if (type == 0) id = builder.add_distance({i}, {j}, {1.0 + k}), kind.push_back("distance");
    if (type == 3) {  // backwards along the line: becomes runs
      const int n = 28 - k / 4;
      id = builder.add_distance({n}, {n + 1}, {1.0 + k});
      kind.push_back("distance");
    }
    if (type == 1) id = builder.add(CurvatureRow{{i, j, l}, 1.0 + k, 0.0}), kind.push_back("curvature");
    if (type == 2) id = builder.add(AngleRow{{i, j, l}, 1.0 + k, 0.0, 1.0}), kind.push_back("angle");
    EXPECT_EQ(id, k);
  }
  const auto [system, state] = builder.build();
  ASSERT_EQ(system.row_of_id.size(), 80u);
  std::set<int> rows;
  bool moved = false, run = false;
  for (int id = 0; id < 80; ++id) {
    const int row = system.row_of_id[id];
    rows.insert(row);
    moved = moved || row != id;
    run = run || (row < system.distance.size() && system.distance.run[row / kBatch] >= 0);
    EXPECT_EQ(system.stiffness[row], stiffness[id]);
    const std::string name = system.row_name(row);
    EXPECT_EQ(name.find(kind[id] + " row " + std::to_string(id) + " (nodes "), 0u) << name;
  }
  EXPECT_EQ(rows.size(), 80u);
  EXPECT_TRUE(moved && run);
}

TEST(System, NamesEveryScalarRowOfABendingElement) {
  SystemBuilder builder = four();
  builder.add_distance({0}, {1}, {1.0});
  const int id = builder.add(CurvatureRow{{3, 1, 2}, 1.0, 0.0});
  const auto [system, state] = builder.build();
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(system.row_name(system.row_of_id[id] + i), "curvature row 1 (nodes 3, 1, 2)");
  EXPECT_EQ(system.row_name(system.row_of_id[0]), "distance row 0 (nodes 0, 1)");
}

TEST(System, CallsALabelledRowByItsLabelAndTheOthersByTheirNodes) {
  SystemBuilder builder;
  const Anchor a = builder.add_particle(1.0, {0, 0, 0}), b = builder.add_particle(1.0, {1, 0, 0}),
               c = builder.add_particle(1.0, {1, 1, 0});
  builder.add_distance(a, b, {.stiffness = 1.0});
  const int bending = builder.add(CurvatureRow{{a.node, b.node, c.node}, 1.0});
  builder.add_distance(b, c, {.stiffness = 1.0});
  builder.label_row(bending, "hinge of the door");
  const System system = builder.build().system;
  for (int i = 0; i < 3; ++i) EXPECT_EQ(system.row_name(system.row_of_id[bending] + i), "hinge of the door");
  EXPECT_EQ(system.row_name(system.row_of_id[2]), "distance row 2 (nodes 1, 2)");
}

TEST(System, ConstantForceOnABodyActsAtItsCentreOfMass) {
  SystemBuilder builder;
  MassProperties box = solid_box("box", 2.0, {1, 1, 1});
  box.centre = {0.3, 0, 0};
  const Anchor body = builder.add_body(box, {});
  builder.add_constant_force(body, {0, 6, 0});
  builder.set_gravity({0, 0, -1});
  const System system = builder.build().system;
  const Vector3d force = system.forces.constant.segment<3>(3 * system.bodies[0].centre);
  EXPECT_EQ(force, Vector3d(0, 6, -2));
  EXPECT_EQ(system.forces.constant.norm(), force.norm());  // and no torque
}

TEST(System, CountsItsRows) {
  const TestScene scene = mixed_scene(1);
  const System& s = scene.system;
  EXPECT_EQ(s.rows, s.distance.size() + 2 * 3 + 3);
  EXPECT_EQ(s.active_rows,
            11 + 2 + 1 + 2 + 6 + 2);  // of 17 distance rows one has stiffness 0, as has one angle
  EXPECT_EQ(static_cast<int>(s.inactive_distance.size()), s.distance.size() - 16);
  EXPECT_TRUE(s.has_hard_rows);
  EXPECT_TRUE(s.has_damping);
  const TestScene plain = mixed_scene(1, {.rods = false, .damping = false});
  EXPECT_FALSE(plain.system.has_hard_rows);
  EXPECT_FALSE(plain.system.has_damping);  // a damped row of stiffness 0 is not damped
}

}  // namespace
}  // namespace feder
