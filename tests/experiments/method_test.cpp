#include "experiments/support/method.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/check.h"
#include "tests/experiments/scene_text.h"
#include "tests/support/random.h"

namespace feder::experiments {
namespace {

std::vector<double> every(double interval, double end) {
  return frame_times({.interval = interval}, end);
}

std::string refusal(const Output& output, double end) {
  try {
    (void)frame_times(output, end);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(FrameTimes, AreMultiplesOfTheIntervalInOneRounding) {
  const std::vector<double> times = every(0.1, 1000.0);
  ASSERT_EQ(times.size(), 10001u);
  for (std::size_t k = 0; k + 1 < times.size(); ++k) ASSERT_EQ(times[k], static_cast<double>(k) * 0.1) << k;
  EXPECT_EQ(times.back(), 1000.0);
}

TEST(FrameTimes, EndWithAShorterIntervalWhereItDoesNotDivide) {
  EXPECT_EQ(every(0.3, 1.0), (std::vector<double>{0.0, 0.3, 0.6, 3 * 0.3, 1.0}));
  EXPECT_EQ(every(5.0, 1.0), (std::vector<double>{0.0, 1.0}));
  EXPECT_EQ(every(1.0, 1.0), (std::vector<double>{0.0, 1.0}));
}

TEST(FrameTimes, AreAHundredWithoutAnInterval) {
  const std::vector<double> times = frame_times({}, 0.7);
  EXPECT_EQ(times.size(), 101u);
  EXPECT_EQ(times.back(), 0.7);
}

TEST(FrameTimes, AddNoFrameForRoundingOfTheEnd) {
  for (double end : {std::nextafter(1.0, 0.0), 1.0, std::nextafter(1.0, 2.0)}) {
    const std::vector<double> times = every(0.1, end);
    EXPECT_EQ(times.size(), 11u);
    EXPECT_EQ(times.back(), end);
  }
}

TEST(FrameTimes, AscendToTheEndForAnyInterval) {
  Random random(1);
  for (int i = 0; i < 3000; ++i) {
    const double end = std::pow(10.0, random.uniform(-6, 6));
    const double interval =
        i % 3 ? end / std::pow(10.0, random.uniform(-1, 3)) : end / (1 + random.below(900));
    const std::vector<double> times = every(interval, end);
    ASSERT_EQ(times.front(), 0.0);
    ASSERT_EQ(times.back(), end);
    for (std::size_t k = 1; k < times.size(); ++k) {
      ASSERT_GT(times[k], times[k - 1]);
      ASSERT_LE(times[k] - times[k - 1], interval * (1 + 1e-8) + 1e-15 * end) << interval << " " << end;
      // a last interval of rounding alone would be no interval
      ASSERT_GT(times[k] - times[k - 1], 0.9e-9 * interval) << interval << " " << end;
    }
  }
}

TEST(FrameTimes, OfAListAreTheListWithStartAndEnd) {
  EXPECT_EQ(frame_times({.times = {0.2, 0.5}}, 1.0), (std::vector<double>{0.0, 0.2, 0.5, 1.0}));
  EXPECT_EQ(frame_times({.times = {0.2, 1.0}}, 1.0), (std::vector<double>{0.0, 0.2, 1.0}));
  const double almost = std::nextafter(1.0, 0.0);
  EXPECT_EQ(frame_times({.times = {almost}}, 1.0), (std::vector<double>{0.0, almost, 1.0}));
}

TEST(FrameTimes, BeyondTheEndOrOutOfOrderAreRefusedWithTheirValue) {
  EXPECT_EQ(refusal({.times = {0.5, std::nextafter(1.0, 2.0)}}, 1.0),
            "output: time = 1.0000000000000002 s, expected ascending times up to the end, 1 s");
  EXPECT_EQ(refusal({.times = {0.5, 0.25}}, 1.0),
            "output: time = 0.25 s, expected ascending times up to the end, 1 s");
  EXPECT_NE(refusal({.times = {0.5, 0.5}}, 1.0), "accepted");
  EXPECT_NE(refusal({.times = {std::nan("")}}, 1.0), "accepted");
}

TEST(FrameTimes, AreRefusedWhereThereAreTooMany) {
  EXPECT_EQ(refusal({.interval = 1e-8}, 1.0), "output: interval = 1e-08 s, expected at most 1e7 frames");
  EXPECT_NE(refusal({.interval = 5e-324}, 1.0), "accepted");
  EXPECT_EQ(every(1e-7, 1.0).size(), 10'000'001u);
}

std::string problem(const std::string& tables) {
  try {
    (void)scene_from(
        "end_time = 1\nscene_length = 1\n[[particle]]\nname = \"p\"\nmass = 1\nposition = [0, 0, 0]\n" +
        tables);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(MethodTable, ReachesTheIntegratorsOptions) {
  const ReadScene read = scene_from(
      "end_time = 1\nscene_length = 1\n[[particle]]\nname = \"p\"\nmass = 1\nposition = [0, 0, 0]\n[method]\n"
      "integrator = \"rk4\"\nroute = \"dense\"\ndt = 0.25\ntolerance = 1e-5\nmax_seconds = 3\ndivergence = "
      "7\n"
      "rotation_update = \"normalised_euler\"\nnewton_tolerance = 1e-9\nmost_newton_iterations = 4\nsweeps = "
      "7\nsubsteps = 3\n"
      "[output]\ntimes = [0.5]\nfiles = [\"npy\"]\ncheckpoint_frames = 9\n");
  const Method& m = read.method;
  EXPECT_EQ(m.integrator, "rk4");
  EXPECT_EQ(m.options.route, "dense");
  EXPECT_EQ(m.dt, 0.25);
  EXPECT_EQ(m.tolerance, 1e-5);
  EXPECT_EQ(m.max_seconds, 3.0);
  EXPECT_EQ(m.divergence, 7.0);
  EXPECT_EQ(m.options.rotation_update, RotationUpdate::kNormalisedEuler);
  EXPECT_EQ(m.options.newton_tolerance, 1e-9);
  EXPECT_EQ(m.options.most_newton_iterations, 4);
  EXPECT_EQ(m.options.sweeps, 7);
  EXPECT_EQ(m.options.substeps, 3);
  EXPECT_EQ(read.output.times, std::vector<double>{0.5});
  EXPECT_EQ(read.output.files, std::vector<std::string>{"npy"});
  EXPECT_EQ(read.output.checkpoint_frames, 9);
}

TEST(MethodTable, RefusesWhatNoRunCouldUse) {
  for (const char* bad :
       {"[method]\ndt = 0", "[method]\ndt = -1", "[method]\ndt = nan", "[method]\ndt = inf",
        "[method]\ntolerance = 0", "[method]\nintegrator = \"leapfrg\"", "[method]\nroute = \"lu\"",
        "[method]\nmax_seconds = 0", "[method]\ndivergence = 0.5", "[method]\nmost_newton_iterations = 1.5",
        "[method]\nsweeps = 0", "[method]\nsubsteps = 0", "[method]\nstep = 1", "[output]\ninterval = 0",
        "[output]\ntimes = [0]", "[output]\ntimes = [0.5]\ninterval = 0.1", "[output]\nfiles = [\"state\"]",
        "[output]\ncheckpoint_frames = 0"})
    EXPECT_TRUE(problem(bad).starts_with("test.toml:")) << bad << ": " << problem(bad);
}

}  // namespace
}  // namespace feder::experiments
