#include "solvers/reference.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <set>

#include "models/catalog.h"
#include "tests/support/scenes.h"

namespace feder {
namespace {

namespace fs = std::filesystem;

// A cache of its own that disappears with the test.
class ReferenceCache : public testing::Test {
 protected:
  ReferenceCache()
      : folder_(fs::path(testing::TempDir()) /
                ("feder_reference_" + std::to_string(::getpid()) + "_" +
                 testing::UnitTest::GetInstance()->current_test_info()->name())) {
    fs::remove_all(folder_);
    options_.cache_folder = folder_;
  }
  ~ReferenceCache() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  fs::path folder_;
  ReferenceOptions options_;
};

struct Numbers {
  double mass = 0.5, stiffness = 300.0, rest = 0.9, tau = 0.01, gravity = -9.81, drag = 0.1, x = 1.0, v = 0.2,
         push = 1.0, rest_angle = 1.0, end = 0.4;
};

TestScene two_links(const Numbers& n) {
  SystemBuilder builder;
  const Anchor a = builder.add_world_point({0, 0, 0}),
               b = builder.add_particle(n.mass, {n.x, 0, 0}, {0, n.v, 0}),
               c = builder.add_particle(1.0, {1, 1, 0});
  builder.add_distance(a, b, {n.stiffness, n.tau}, n.rest);
  builder.add_distance(b, c, {200.0}, 1.0);
  builder.add(AngleRow{{0, 1, 2}, 5.0, 0.0, n.rest_angle});
  builder.set_gravity({0, n.gravity, 0});
  builder.set_drag(n.drag);
  builder.add_constant_force(c, {n.push, 0, 0});
  auto [system, state] = builder.build();
  return {std::move(system), std::move(state)};
}

bool same_bits(const State& a, const State& b) {
  return a.t == b.t && a.q == b.q && a.v == b.v;
}

TEST_F(ReferenceCache, SecondCallReturnsTheSameBits) {
  const auto [system, state] = two_links({});
  const Reference first = make_reference(system, state, 0.4, options_),
                  second = make_reference(system, state, 0.4, options_);
  ASSERT_TRUE(first.status.ok()) << first.status.reason;
  EXPECT_FALSE(first.from_cache);
  EXPECT_TRUE(second.from_cache);
  EXPECT_TRUE(same_bits(first.state, second.state));
  EXPECT_EQ(first.error, second.error);
  EXPECT_EQ(first.method, second.method);
}

TEST_F(ReferenceCache, DamagedFilesAreRecomputed) {
  const auto [system, state] = two_links({});
  const Reference first = make_reference(system, state, 0.4, options_);
  const fs::path file = *reference_cache_file(system, state, 0.4, options_);
  ASSERT_TRUE(fs::exists(file));
  const auto size = fs::file_size(file);
  const std::function<void()> damages[] = {
      [&] { std::fstream(file, std::ios::in | std::ios::out | std::ios::binary).seekp(60).put('x'); },
      [&] { fs::resize_file(file, size / 2); },
      [&] { fs::resize_file(file, 0); },
      [&] { std::ofstream(file, std::ios::app | std::ios::binary).put('x'); },
  };
  for (const auto& damage : damages) {
    damage();
    const Reference again = make_reference(system, state, 0.4, options_);
    ASSERT_TRUE(again.status.ok());
    EXPECT_FALSE(again.from_cache);
    EXPECT_TRUE(same_bits(first.state, again.state));
    EXPECT_TRUE(make_reference(system, state, 0.4, options_).from_cache);  // and is whole again
  }
}

TEST_F(ReferenceCache, EveryNumberOfTheSceneChangesTheKey) {
  std::set<fs::path> keys;
  auto add = [&](const Numbers& n, const ReferenceOptions& options) {
    const auto [system, state] = two_links(n);
    keys.insert(*reference_cache_file(system, state, n.end, options));
  };
  add({}, options_);
  add({}, options_);
  ASSERT_EQ(keys.size(), 1u);
  for (double Numbers::*number :
       {&Numbers::mass, &Numbers::stiffness, &Numbers::rest, &Numbers::tau, &Numbers::gravity, &Numbers::drag,
        &Numbers::x, &Numbers::v, &Numbers::push, &Numbers::rest_angle, &Numbers::end}) {
    Numbers changed;
    changed.*number *= 1.0 + 1e-12;
    add(changed, options_);
  }
  ReferenceOptions other = options_;
  other.judge.relative_tolerance *= 2.0;
  add({}, other);
  EXPECT_EQ(keys.size(), 13u);
}

TEST_F(ReferenceCache, SceneWithAUserForceIsNotCached) {
  const auto [system, state] = mixed_scene(2, {.rods = false});
  EXPECT_FALSE(reference_cache_file(system, state, 1.0, options_).has_value());
  const Reference reference = make_reference(system, state, state.t + 0.01, options_);
  EXPECT_TRUE(reference.status.ok()) << reference.status.reason;
  EXPECT_FALSE(fs::exists(folder_));
}

TEST_F(ReferenceCache, UnwritableFolderCostsTimeOnly) {
  options_.cache_folder = "/proc/feder";
  const auto [system, state] = two_links({});
  EXPECT_TRUE(make_reference(system, state, 0.1, options_).status.ok());
}

TEST_F(ReferenceCache, FailuresAreNotKept) {
  SystemBuilder builder;  // two rods that contradict each other
  const Anchor a = builder.add_world_point({0, 0, 0}), b = builder.add_particle(1.0, {1, 0, 0});
  for (int i = 0; i < 2; ++i) builder.add_distance(a, b, {INFINITY}, 1.0 + 0.1 * i);
  const auto [system, state] = builder.build();
  const Reference reference = make_reference(system, state, 1.0, options_);
  EXPECT_EQ(reference.status.code, StatusCode::kInconsistent);
  EXPECT_NE(reference.status.reason.find("distance row"), std::string::npos) << reference.status.reason;
  EXPECT_FALSE(fs::exists(folder_));
}

// ---- What a reference is worth
// ----------------------------------------------------------------------------------------

TEST(Reference, PositionErrorIsTheMassWeightedRootMeanSquare) {
  SystemBuilder builder;
  builder.add_world_point({0, 0, 0});
  builder.add_particle(1.0, {0, 0, 0});
  builder.add_particle(3.0, {1, 0, 0});
  builder.add_particle(100.0, {2, 0, 0}, Vector3d::Zero(), kPinned);
  const auto [system, state] = builder.build();
  State moved = state;
  moved.q.segment<3>(3) += Vector3d(0.3, 0, 0.4);
  moved.q.segment<3>(6) += Vector3d(0, 1, 0);
  EXPECT_DOUBLE_EQ(position_error(system, state, moved), std::sqrt((0.25 + 3.0) / 4.0));
  EXPECT_EQ(position_error(system, state, state), 0.0);
}

TEST(Reference, ErrorBarCoversTheTrueError) {
  for (double damping_time : {0.0, 0.02}) {
    SystemBuilder builder;
    const Anchor wall = builder.add_world_point({0, 0, 0});
    builder.add_distance(wall, builder.add_particle(1.0, {1.1, 0, 0}), {100.0, damping_time}, 1.0);
    const auto [system, state] = builder.build();
    const double end = 1.3, decay = 50.0 * damping_time, omega = std::sqrt(100.0 - decay * decay);
    const double exact =
        1.0 + 0.1 * std::exp(-decay * end) * (std::cos(omega * end) + decay / omega * std::sin(omega * end));
    for (const auto& method : {ida_reference, explicit_reference}) {
      const Reference reference = method(system, state, end, {});
      ASSERT_TRUE(reference.status.ok()) << reference.status.reason;
      EXPECT_GT(reference.error, 0.0) << reference.method;
      EXPECT_LE(std::abs(reference.state.q[3] - exact), reference.error) << reference.method;
      EXPECT_LT(reference.error, 1e-5) << reference.method;
    }
  }
}

TEST(Reference, ExplicitPathAgreesWithIdaWithinBothErrors) {
  for (bool damping : {false, true}) {
    const auto [system, state] = mixed_scene(7, {.rods = false, .damping = damping, .user_force = false});
    const double end = state.t + 0.5;
    const Reference ida = ida_reference(system, state, end), stepped = explicit_reference(system, state, end);
    ASSERT_TRUE(ida.status.ok()) << ida.status.reason;
    ASSERT_TRUE(stepped.status.ok()) << stepped.status.reason;
    EXPECT_EQ(stepped.method.substr(0, 3), damping ? "rk4" : "lea");
    ASSERT_GT(position_error(system, state, ida.state), 0.1);
    EXPECT_LT(position_error(system, ida.state, stepped.state), ida.error + stepped.error) << stepped.method;
  }
}

TEST(Reference, LargeScenesTakeTheExplicitPath) {
  const auto [system, state] = mixed_scene(8, {.rods = false, .damping = false, .user_force = false});
  ReferenceOptions options;
  options.use_cache = false;
  EXPECT_EQ(make_reference(system, state, state.t + 0.1, options).method.substr(0, 3), "ida");
  options.most_ida_unknowns = 10;
  EXPECT_EQ(make_reference(system, state, state.t + 0.1, options).method.substr(0, 8), "leapfrog");
}

TEST(Reference, ExhaustedJudgeIsReplacedAndTheMethodSaysSo) {
  const auto [system, state] = mixed_scene(8, {.rods = false, .damping = false, .user_force = false});
  ReferenceOptions options;
  options.use_cache = false;
  options.judge.max_steps = 5;
  const Reference reference = make_reference(system, state, state.t + 0.1, options);
  EXPECT_TRUE(reference.status.ok()) << reference.status.reason;
  EXPECT_EQ(reference.method.substr(0, 8), "leapfrog");
  EXPECT_NE(reference.method.find("step budget"), std::string::npos) << reference.method;
}

TEST(HalvingReference, OfARodPendulumIsAsGoodAsItSays) {
  const Model model = make_model("pendulum");
  const double end = 0.4 * model.end_time;
  ReferenceOptions options;
  options.halving_accuracy = 1e-5;
  const Reference r = halving_reference(model.system, model.state, end, options);
  ASSERT_TRUE(r.status.ok()) << r.status.reason;
  EXPECT_LT(r.error, 1e-5);
  EXPECT_GT(r.error, 0.0);
  EXPECT_LT(position_error(model.system, r.state, model.exact(end)), r.error);  // order 2: a third of it
}

TEST(HalvingReference, OfAJointedChainShrinksWithItsTarget) {
  const Model model = make_model("S3c(3)");
  ReferenceOptions rough, fine;
  rough.halving_accuracy = 1e-3;
  fine.halving_accuracy = 1e-5;
  const Reference a = halving_reference(model.system, model.state, 0.2, rough),
                  b = halving_reference(model.system, model.state, 0.2, fine);
  ASSERT_TRUE(a.status.ok() && b.status.ok());
  EXPECT_LT(b.error, 1e-5 * 0.3);
  EXPECT_LT(position_error(model.system, a.state, b.state), a.error);
}

}  // namespace
}  // namespace feder
