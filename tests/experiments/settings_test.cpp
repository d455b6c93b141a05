#include "experiments/support/settings.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/check.h"

namespace feder::experiments {
namespace {

std::vector<Setting> declared() {
  return {{"dt", Kind::kNumbers, "0.1,0.05", "1e-4:1e-1:4", "time steps, s"},
          {"end_time", Kind::kNumber, "1", "10", "end time, s"},
          {"repeats", Kind::kInteger, "1", "5", "timings per case"},
          {"scene", Kind::kText, "chain", "cloth", "scene", {"chain", "cloth"}},
          {"integrators", Kind::kTexts, "bdf2", "bdf2,rk4", "methods", {"bdf2", "rk4", "leapfrog"}}};
}

std::string message(const std::vector<std::string>& changes, const std::string& preset = "quick") {
  try {
    const Settings settings(declared(), preset, changes);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Settings, TakesTheValuesOfThePreset) {
  const Settings quick(declared(), "quick", {});
  const Settings full(declared(), "full", {});
  EXPECT_EQ(quick.numbers("dt"), (std::vector<double>{0.1, 0.05}));
  EXPECT_EQ(quick.number("end_time"), 1);
  EXPECT_EQ(full.integer("repeats"), 5);
  EXPECT_EQ(full.text("scene"), "cloth");
  EXPECT_EQ(full.texts("integrators"), (std::vector<std::string>{"bdf2", "rk4"}));
}

TEST(Settings, KeepsTheSizesOfAPresetTogether) {
  EXPECT_EQ(parse_texts("test", "S1(3),S3b(30,10),chain"),
            (std::vector<std::string>{"S1(3)", "S3b(30,10)", "chain"}));
  EXPECT_THROW((void)parse_texts("test", "S3b(30,10),"), InputError);
}

TEST(Settings, LetsTheLastChangeWin) {
  const Settings settings(declared(), "quick", {"end_time=2", "end_time=-3e-1"});
  EXPECT_EQ(settings.number("end_time"), -0.3);
}

TEST(Settings, NamesAnUnknownKeyAndTheNearestOne) {
  EXPECT_EQ(message({"end_tiem=2"}), "--set end_tiem=2: unknown setting 'end_tiem'; nearest is 'end_time'");
  EXPECT_EQ(message({"dt"}), "--set: got 'dt', expected key=value");
  EXPECT_NE(message({"=1"}).find("unknown setting ''"), std::string::npos);
  EXPECT_EQ(message({}, "ful"), "preset: got 'ful', expected quick or full; nearest is 'full'");
}

TEST(Settings, NamesKeyValueAndExpectation) {
  EXPECT_EQ(message({"end_time=abc"}), "setting 'end_time': got 'abc', expected a finite number");
  EXPECT_EQ(message({"repeats=1.5"}), "setting 'repeats': got '1.5', expected a whole number");
  EXPECT_EQ(message({"scene=clot"}),
            "setting 'scene': got 'clot', expected one of chain, cloth; nearest is 'cloth'");
  EXPECT_EQ(message({"integrators=bdf2,"}),
            "setting 'integrators': got 'bdf2,', expected words separated by single commas");
  EXPECT_NE(message({"dt=1:2"}).find("setting 'dt': got '1:2', expected a logarithmic grid"),
            std::string::npos);
}

TEST(Settings, RefusesEveryNumberThatIsNotFiniteOrNotWholly) {
  for (const char* text :
       {"nan", "inf", "-inf", "1e999", "", " 1", "1 ", "1kg", "0x10", "1,5", "--1", "+-1", "1e", "."}) {
    EXPECT_NE(message({std::string("end_time=") + text}), "accepted") << text;
  }
  for (const char* text : {"99999999999999999999", "1e3", "", "1 "}) {
    EXPECT_NE(message({std::string("repeats=") + text}), "accepted") << text;
  }
}

TEST(Settings, RefusesToBeReadWithAnotherKind) {
  const Settings settings(declared(), "quick", {});
  EXPECT_THROW((void)settings.number("dt"), MisuseError);
  EXPECT_THROW((void)settings.text("no_such_key"), MisuseError);
}

TEST(LogGrid, HasExactEndsAndAConstantRatio) {
  const std::vector<double> grid = parse_numbers("test", "1e-4:1e-1:13");
  ASSERT_EQ(grid.size(), 13u);
  EXPECT_EQ(grid.front(), 1e-4);
  EXPECT_EQ(grid.back(), 1e-1);
  for (std::size_t i = 1; i < grid.size(); ++i)
    EXPECT_NEAR(grid[i] / grid[i - 1], std::pow(10, 0.25), 1e-13);  // 9e-15
}

TEST(LogGrid, HitsDecadesExactly) {
  EXPECT_EQ(parse_numbers("test", "1e2:1e8:7"), (std::vector<double>{1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8}));
  EXPECT_EQ(parse_numbers("test", "1e-6:1e-3:4"), (std::vector<double>{1e-6, 1e-5, 1e-4, 1e-3}));
}

TEST(LinearGrid, HasExactEndsAndEqualSteps) {
  EXPECT_EQ(parse_numbers("test", "-1:1:5:lin"), (std::vector<double>{-1, -0.5, 0, 0.5, 1}));
  EXPECT_EQ(parse_numbers("test", "0.1:0.3:3:lin"), (std::vector<double>{0.1, 0.2, 0.3}));
}

TEST(LinearGrid, RefusesOtherWords) {
  for (const char* text : {"0:1:3:log", "0:1:1:lin", "0:inf:3:lin", "0:1:3:lin:lin", "0:1:lin"})
    EXPECT_THROW((void)parse_numbers("test", text), InputError) << text;
}

TEST(LogGrid, MayRunDownwards) {
  EXPECT_EQ(parse_numbers("test", "8:2:2"), (std::vector<double>{8, 2}));
}

TEST(LogGrid, RefusesWhatHasNoLogarithmOrNoSize) {
  for (const char* text :
       {"0:1:3", "-1:1:3", "1:2:1", "1:2:0", "1:2:-3", "1:2:1000000", "1:2:3:4", "1:inf:3", "a:b:c", "::"}) {
    EXPECT_THROW((void)parse_numbers("test", text), InputError) << text;
  }
}

TEST(Nearest, CountsInsertionsDeletionsAndChanges) {
  EXPECT_EQ(nearest("stifness", {"damping", "stiffness", "mass"}), "stiffness");
  EXPECT_EQ(nearest("mas", {"damping", "stiffness", "mass"}), "mass");
  EXPECT_EQ(nearest("x", {}), "");
}

}  // namespace
}  // namespace feder::experiments
