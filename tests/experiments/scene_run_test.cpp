#include "experiments/support/scene_run.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "engine/check.h"
#include "solvers/simulate.h"
#include "tests/experiments/scene_text.h"
#include "tests/experiments/temporary_folder.h"

namespace feder::experiments {
namespace {

const std::string kSpring =
    "gravity = [0, 0, -9.81]\n[[point]]\nname = \"hook\"\nposition = [0, 0, 0]\n"
    "[[particle]]\nname = \"p\"\nmass = 0.5\nposition = [0.3, 0, -1]\n"
    "[[spring]]\nbetween = [\"hook\", \"p\"]\nstiffness = 400\nlength = 1\n";

std::string spring(const std::string& end_time, const std::string& method, const std::string& output = "") {
  return "end_time = " + end_time + "\n" + kSpring + "[method]\n" + method + "\n[output]\n" + output + "\n";
}

bool same(const VectorXd& a, const VectorXd& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

/// The first column of a table, below its title.
std::vector<double> times_in(const std::filesystem::path& file) {
  std::istringstream lines(read_file(file));
  std::vector<double> times;
  std::string line;
  std::getline(lines, line);
  EXPECT_TRUE(line.starts_with("t,")) << line;
  while (std::getline(lines, line)) times.push_back(std::strtod(line.c_str(), nullptr));
  return times;
}

TEST(SceneRun, WithOneFrameIsTheSolversRun) {
  for (const IntegratorInfo& info : integrator_list()) {
    const TemporaryFolder folder;
    ReadScene read = scene_from(spring("0.37", "dt = 1e-3", "interval = 0.37"));
    read.method.integrator = info.name;
    const RunReport report = run_in(folder.path(), read);
    ASSERT_TRUE(report.status.ok()) << info.name << ": " << report.status.reason;
    EXPECT_EQ(report.frames, 2);
    EXPECT_EQ(report.steps, 370);

    const Model& model = read.scene().model;
    Integrator integrator = make_integrator(info.name, model.system);
    State state = model.state;
    History history;
    ASSERT_TRUE(
        simulate(model.system, integrator, state, history, {.dt = 1e-3, .end_time = 0.37}).status.ok());
    EXPECT_FALSE(same(state.q, model.state.q));
    EXPECT_TRUE(same(report.state.q, state.q)) << info.name;
    EXPECT_TRUE(same(report.state.v, state.v)) << info.name;
    EXPECT_EQ(report.state.t, 0.37);
  }
}

TEST(SceneRun, KeepsTheTimeOfEveryFrameToTheBit) {
  const TemporaryFolder folder;
  ReadScene read = scene_from(spring("100", "integrator = \"leapfrog\"\ndt = 0.01", "interval = 0.1"));
  const RunReport report = run_in(folder.path(), read);
  ASSERT_TRUE(report.status.ok()) << report.status.reason;
  EXPECT_EQ(report.dt, 0.01);
  EXPECT_EQ(report.steps, 10000);
  const std::vector<double> times = times_in(folder.path() / "energy.csv");
  ASSERT_EQ(times.size(), 1001u);
  for (std::size_t k = 0; k < times.size(); ++k)
    ASSERT_EQ(times[k], k == 1000 ? 100.0 : static_cast<double>(k) * 0.1);
}

TEST(SceneRun, TakesEqualStepsWhereTheIntervalIsNoMultiple) {
  const TemporaryFolder folder;
  ReadScene read = scene_from(spring("1", "integrator = \"leapfrog\"\ndt = 0.03", "interval = 0.1"));
  const RunReport report = run_in(folder.path(), read);
  EXPECT_NEAR(report.dt, 0.025, 1e-15);
  EXPECT_EQ(report.steps, 40);
  EXPECT_EQ(report.frames, 11);
}

TEST(SceneRun, RefusesStepsTheClockCannotResolveBeforeItWritesAnything) {
  for (const char* dt : {"1e-17", "1e-300", "1e-13"}) {
    const TemporaryFolder folder;
    auto run = [&] {  // the first two the reader refuses already
      ReadScene read = scene_from(spring("4096", "integrator = \"leapfrog\"\ndt = " + std::string(dt)));
      (void)run_in(folder.path(), read);
    };
    EXPECT_THROW(run(), InputError) << dt;
    EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << dt;
  }
}

TEST(SceneRun, HoldsTheToleranceOfAnAdaptiveRun) {
  double before = HUGE_VAL;
  for (const char* tolerance : {"1e-4", "1e-6", "1e-8"}) {
    const TemporaryFolder folder;
    ReadScene coarse = scene_from(spring(
        "1", "integrator = \"rk4\"\ndt = 1e-2\ntolerance = " + std::string(tolerance), "interval = 0.5"));
    ReadScene fine = scene_from(spring("1", "integrator = \"rk4\"\ndt = 1e-5", "interval = 0.5"));
    const RunReport a = run_in(folder.path() / "a", coarse), b = run_in(folder.path() / "b", fine);
    ASSERT_TRUE(a.status.ok()) << a.status.reason;
    const double error = (a.state.q - b.state.q).norm();
    EXPECT_LT(error, 100 * std::stod(tolerance)) << tolerance;
    EXPECT_LT(error, 0.2 * before) << tolerance;
    EXPECT_GT(error, 0.0);
    before = error;
    EXPECT_EQ(times_in(folder.path() / "a" / "energy.csv").size(), 3u);
  }
}

TEST(SceneRun, EndsWhereItsBudgetOfTimeIsUsedUp) {
  for (const char* more : {"", "tolerance = 1e-12\n"}) {
    const TemporaryFolder folder;
    ReadScene read = scene_from(
        spring("1e6", "integrator = \"leapfrog\"\ndt = 1e-3\nmax_seconds = 0.2\n" + std::string(more),
               "interval = 5e5"));
    const RunReport report = run_in(folder.path(), read);
    EXPECT_EQ(report.status.code, StatusCode::kLimitReached) << report.status.reason;
    EXPECT_TRUE(report.status.reason.starts_with("wall-clock budget used up at t = "))
        << report.status.reason;
    EXPECT_GT(report.state.t, 0.0);
    EXPECT_LT(report.state.t, 5e5);
    EXPECT_GE(report.seconds, 0.19);
    EXPECT_LT(report.seconds, 5.0);
    EXPECT_EQ(times_in(folder.path() / "energy.csv"), std::vector<double>{0.0});
  }
}

TEST(SceneRun, EndsAsDivergedWithTheFramesSoFarComplete) {
  const TemporaryFolder folder;
  ReadScene read = scene_from(spring("100", "integrator = \"explicit_euler\"\ndt = 0.02", "interval = 0.1"));
  const RunReport report = run_in(folder.path(), read);
  EXPECT_EQ(report.status.code, StatusCode::kDiverged) << report.status.reason;
  const std::vector<double> times = times_in(folder.path() / "energy.csv");
  EXPECT_GT(times.size(), 3u);
  EXPECT_EQ(static_cast<std::int64_t>(times.size()), report.frames);
  EXPECT_EQ(times_in(folder.path() / "states.csv").size(), 2 * times.size());
  EXPECT_TRUE(std::isnan(report.energy_drift));
}

TEST(SceneRun, IsRefusedWithTheReason) {
  const TemporaryFolder folder;
  ReadScene read = scene_from(
      "end_time = 1\n[[point]]\nname = \"a\"\nposition = [0, 0, 0]\n[[particle]]\nname = \"b\"\nmass = 1\n"
      "position = [1, 0, 0]\n[[spring]]\nbetween = [\"a\", \"b\"]\nstiffness = \"rigid\"\n"
      "[method]\nintegrator = \"explicit_euler\"\ndt = 0.01\n");
  const RunReport report = run_in(folder.path(), read);
  EXPECT_EQ(report.status.code, StatusCode::kRefused);
  EXPECT_NE(report.status.reason.find("rigid"), std::string::npos) << report.status.reason;
  EXPECT_EQ(report.steps, 0);
  EXPECT_EQ(report.frames, 1);
}

// A motion, a motor's target and a force that have no value from t = 0.5 s on.
TEST(SceneRun, EndsWhereAnExpressionGivesABadNumber) {
  const std::string bodies =
      "[[body]]\nname = \"wheel\"\nshape = \"sphere\"\nmass = 1\nradius = 0.1\n[[joint]]\ntype = \"hinge\"\n"
      "between = [\"world\", \"wheel\"]\nplace = [0, 0, 0]\naxis = [0, 0, 1]\n";
  const std::pair<std::string, std::string> cases[] = {
      {"[[point]]\nname = \"hand\"\nmotion = [\"sqrt(0.4999 - t)\", 2, 0]\n[[spring]]\n"
       "between = [\"hand\", \"p\"]\nstiffness = 1\n",
       "'hand'"},
      {bodies + "[[turn]]\nbetween = [\"world\", \"wheel\"]\naxis = [0, 0, 1]\nstiffness = 1\n"
                "target = \"sqrt(0.4999 - t)\"\n",
       "motion"},
      {"[[force]]\non = \"p\"\nforce = [\"ln(0.4999 - t)\", 0, 0]\n", "the force on 'p'"}};
  for (const auto& [table, what] : cases)
    for (const char* integrator : {"leapfrog", "rk4", "implicit_euler_notes", "implicit_euler_newton"}) {
      const TemporaryFolder folder;
      ReadScene read =
          scene_from("end_time = 1\n" + kSpring + table + "[method]\ndt = 1e-3\nintegrator = \"" +
                     integrator + "\"\n[output]\ninterval = 0.04\n");
      const RunReport report = run_in(folder.path(), read);
      SCOPED_TRACE(std::string(integrator) + " " + what + ": " + report.status.reason);
      EXPECT_EQ(report.status.code, StatusCode::kNonFinite);
      EXPECT_NE(report.status.reason.find(what), std::string::npos);
      EXPECT_NE(report.status.reason.find("t = 0.499 s"), std::string::npos);
      EXPECT_NEAR(report.state.t, 0.499, 1e-12);
      EXPECT_TRUE(report.state.q.allFinite() && report.state.v.allFinite());
      EXPECT_EQ(times_in(folder.path() / "energy.csv").size(), 13u);  // 0, 0.04 ... 0.48
    }
}

TEST(SceneRun, ReportsADiskThatRefuses) {
  const TemporaryFolder folder;
  ReadScene read = scene_from(spring("1", "integrator = \"leapfrog\"\ndt = 1e-2"));
  const RunReport report = run_in(folder.path(), read, false, [&](std::int64_t frames) {
    if (frames == 50) std::filesystem::remove_all(folder.path());
    return true;
  });
  EXPECT_EQ(report.status.code, StatusCode::kIoError) << report.status.reason;
}

}  // namespace
}  // namespace feder::experiments
