// A run that goes on from a checkpoint is bitwise the run that never stopped: every integrator, on scenes
// with every kind of row and force, from every checkpoint.
#include <gtest/gtest.h>

#include <map>
#include <vector>

#include "experiments/support/simulate_manifest.h"
#include "solvers/integrators.h"
#include "tests/experiments/scene_text.h"
#include "tests/experiments/temporary_folder.h"

namespace feder::experiments {
namespace {

namespace fs = std::filesystem;

const std::string kCloth =
    "end_time = 0.06\ngravity = [0, 0, -9.81]\ndrag = 0.01\n[[cloth]]\nname = \"cloth\"\nedge_u = [1, 0, 0]\n"
    "edge_v = [0, 1, 0]\ncount = [6, 5]\nmass = 0.2\nstiffness = 500\nbend_stiffness = 5\ndamping_time = "
    "1e-3\n"
    "fixed = [\"c00\", \"c10\"]\n";

const std::string kLaws =
    "end_time = 0.06\ngravity = [0, -9.81, 0]\n[[chain]]\nname = \"rope\"\nfrom = [0, 0, 0]\nto = [1, 0, 0]\n"
    "count = 6\nmass = 0.3\nstiffness = 2e3\nbending_stiffness = 0.5\n[[point]]\nname = \"hand\"\n"
    "motion = [\"0.05*sin(20*t)\", \"0.1*t\", [[0, 0.02], [0.03, 0.03], [1, 0]]]\n[[law_spring]]\n"
    "between = [\"hand\", \"rope[0]\"]\ntension = \"300*length + 0.5*rate + 1000*length^3\"\n[[force]]\n"
    "on = \"rope\"\nforce = [\"sin(50*t)\", \"-0.2*vy\", \"0.3*x*z\"]\n";

const std::string kRods =
    "end_time = 0.06\ngravity = [0, -9.81, 0]\ndrag = 0.02\n[[chain]]\nname = \"rods\"\nfrom = [0, 0, 0]\n"
    "to = [1, 0, 0]\ncount = 6\nmass = 0.3\nstiffness = \"rigid\"\nfixed = [\"first\"]\n[[particle]]\n"
    "name = \"load\"\nmass = 0.2\nposition = [1, -0.5, 0]\n[[spring]]\nbetween = [\"rods[5]\", \"load\"]\n"
    "stiffness = 100\ndamping = 0.1\n";

// A motor over more than a turn, redundant hinges, a slide, joints that give, prescribed motion.
const std::string kMechanism =
    "end_time = 0.06\ngravity = [0, -9.81, 0]\n[[body]]\nname = \"crank\"\nshape = \"box\"\nmass = 0.4\n"
    "edges = [0.2, 0.02, 0.02]\nposition = [0, 0.1, 0]\norientation = {axis = [0, 0, 1], angle = "
    "1.5707963267948966}\n[[body]]\nname = \"coupler\"\nshape = \"box\"\nmass = 1\nedges = [0.5, 0.02, "
    "0.02]\n"
    "position = [0.25, 0.2, 0]\n[[joint]]\nname = \"A\"\ntype = \"hinge\"\nbetween = [\"world\", \"crank\"]\n"
    "place = [0, 0, 0]\naxis = [0, 0, 1]\n[[joint]]\ntype = \"hinge\"\nbetween = [\"crank\", \"coupler\"]\n"
    "place = [0, 0.2, 0]\naxis = [0, 0, 1]\n[[turn]]\nbetween = [\"world\", \"crank\"]\naxis = [0, 0, 1]\n"
    "stiffness = 50\ndamping = 0.1\ntarget = \"150*t\"\n[[spring]]\nbetween = [{body = \"coupler\", point = "
    "[0.25, 0, 0]}, [0.5, -0.3, 0]]\nstiffness = 300\n[[torque]]\non = \"coupler\"\ntorque = [0.01, 0, "
    "0.02]\n";

// No hard rows: what explicit Euler takes, too.
const std::string kTops =
    "end_time = 0.06\ngravity = [0, 0, -9.81]\n[[body]]\nname = \"top\"\nshape = \"box\"\nmass = 0.5\n"
    "edges = [0.3, 0.2, 0.1]\nangular_velocity = [10, 70, 30]\n[[joint]]\ntype = \"ball\"\n"
    "between = [\"world\", \"top\"]\nplace = [0, 0, 0.1]\nstiffness = 2e3\ndamping = 0.5\n[[body]]\n"
    "name = \"free\"\nshape = \"sphere\"\nmass = 1\nradius = 0.1\nposition = [1, 0, 0]\nvelocity = [0, 1, "
    "0]\n"
    "[[law_spring]]\nbetween = [\"top\", {body = \"free\", point = [0, 0.1, 0]}]\ntension = "
    "[[0, -20], [0.5, 0], [1, 3], [5, 50]]\n[[force]]\non = \"free\"\nforce = [\"cos(t)\", \"-vz\", "
    "\"x*vx\"]\n";

const std::map<std::string, std::string>& scenes() {
  static const std::map<std::string, std::string> list = {
      {"cloth", kCloth}, {"laws", kLaws}, {"rods", kRods}, {"mechanism", kMechanism}, {"tops", kTops}};
  return list;
}

/// Every result in a folder by its path. The scene's checkpoint is compared, too.
std::map<std::string, std::string> results_in(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files[fs::relative(entry.path(), folder)] = read_file(entry.path());
  return files;
}

void expect_same(const std::map<std::string, std::string>& a, const std::map<std::string, std::string>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (const auto& [name, bytes] : a) {
    ASSERT_TRUE(b.contains(name)) << name;
    EXPECT_TRUE(b.at(name) == bytes) << name << " differs";
  }
}

struct Case {
  std::string scene, integrator, method;
};

/// Runs a case with a copy of its folder after every frame, as a kill would leave it, and resumes each copy.
/// The end of the whole run, good or not, must be that of every resumed one. Returns it.
Status resume_everywhere(const Case& c) {
  const TemporaryFolder folder;
  ReadScene read = scene_from(scenes().at(c.scene) + "[method]\nintegrator = \"" + c.integrator + "\"\n" +
                              c.method + "[output]\ninterval = 0.01\ncheckpoint_frames = 2\n" + kEveryFile);
  std::vector<fs::path> copies;
  const RunReport whole = run_in(folder.path() / "whole", read, false, [&](std::int64_t frames) {
    copies.push_back(folder.path() / std::to_string(frames));
    fs::copy(folder.path() / "whole", copies.back(), fs::copy_options::recursive);
    return true;
  });
  if (whole.status.code == StatusCode::kRefused) return whole.status;
  const auto expected = results_in(folder.path() / "whole");
  for (const auto& [name, bytes] : expected) EXPECT_FALSE(name.ends_with(".part")) << name;
  EXPECT_EQ(expected.size(), 7u + static_cast<std::size_t>(whole.frames));  // with the vtu frames

  std::vector<std::int64_t> left;
  for (const fs::path& copy : copies) {
    SCOPED_TRACE("resumed after frame " + copy.filename().string());
    left.push_back(0);
    const RunReport again = run_in(copy, read, true, [&](std::int64_t) { return ++left.back() > 0; });
    EXPECT_EQ(again.status.code, whole.status.code);
    EXPECT_EQ(again.status.reason, whole.status.reason);
    EXPECT_EQ(results_hash(again), results_hash(whole));
    expect_same(expected, results_in(copy));
  }
  // frames 2 and 4 (counted from 0) end in a checkpoint; the last one ends the run
  if (whole.status.ok()) EXPECT_EQ(left, (std::vector<std::int64_t>{6, 4, 4, 2, 2, 0}));
  return whole.status;
}

class Resume : public testing::TestWithParam<std::string> {};

bool has_hard_rows(const std::string& scene) {
  return scene == "rods" || scene == "mechanism";
}

TEST_P(Resume, FromEveryCheckpointIsBitwiseTheWholeRun) {
  for (const IntegratorInfo& info : integrator_list()) {
    SCOPED_TRACE(info.name);
    const std::string name = info.name;
    const bool refused =
        has_hard_rows(GetParam()) && (name == "explicit_euler" || name == "symplectic_euler");
    const Status status = resume_everywhere({GetParam(), info.name, "dt = 7e-4\n"});
    EXPECT_EQ(status.code, refused ? StatusCode::kRefused : StatusCode::kOk) << status.reason;
  }
}

// Steps end anywhere and the suggestion for the next one outlives the checkpoint. On hard rows the linearised
// implicit Euler may find no step that is short enough: that is the end of every resumed run, too.
TEST_P(Resume, OfAnAdaptiveRunIsBitwiseTheWholeRun) {
  int whole = 0;
  for (const IntegratorInfo& info : integrator_list()) {
    SCOPED_TRACE(info.name);
    whole += resume_everywhere({GetParam(), info.name, "dt = 1e-4\ntolerance = 1e-3\n"}).ok();
  }
  EXPECT_GE(whole, has_hard_rows(GetParam()) ? 2 : 6);
}

TEST_P(Resume, OnEveryRouteIsBitwiseTheWholeRun) {
  int whole = 0;
  for (const std::string& route : route_names()) {
    SCOPED_TRACE(route);
    whole +=
        resume_everywhere({GetParam(), "implicit_euler_geometric", "dt = 7e-4\nroute = \"" + route + "\"\n"})
            .ok();
  }
  EXPECT_GE(whole, 2);  // some scenes are not for every route
}

std::string name_of(const testing::TestParamInfo<std::string>& info) {
  return info.param;
}

INSTANTIATE_TEST_SUITE_P(Scenes, Resume, testing::Values("cloth", "laws", "rods", "mechanism", "tops"),
                         name_of);

TEST(ResumeAfter, AnInterruptionTakesUpTheFinishedFiles) {
  for (const char* cadence : {"checkpoint_frames = 50\n", ""}) {
    const TemporaryFolder folder;
    ReadScene read =
        scene_from(kRods + "[method]\nintegrator = \"leapfrog\"\ndt = 7e-4\n[output]\ninterval = 2e-4\n" +
                   cadence + kEveryFile);
    const RunReport whole = run_in(folder.path() / "whole", read);
    ASSERT_TRUE(whole.status.ok()) << whole.status.reason;
    const RunReport stopped =
        run_in(folder.path() / "stopped", read, false, [](std::int64_t frames) { return frames < 250; });
    EXPECT_EQ(stopped.status.code, StatusCode::kInterrupted);
    EXPECT_EQ(stopped.frames, 250);
    EXPECT_TRUE(fs::exists(folder.path() / "stopped" / "states.csv"));
    // what is lost are at most the 200 steps since the last checkpoint
    EXPECT_GE(read_checkpoint(folder.path() / "stopped" / kCheckpointFile).frame, 201);
    const RunReport again = run_in(folder.path() / "stopped", read, true);
    EXPECT_EQ(results_hash(again), results_hash(whole));
    expect_same(results_in(folder.path() / "whole"), results_in(folder.path() / "stopped"));
  }
}

TEST(ResumeAfter, NothingWasRunSaysSo) {
  const TemporaryFolder folder;
  ReadScene read = scene_from(kRods + "[method]\nintegrator = \"leapfrog\"\ndt = 7e-4\n");
  try {
    (void)run_in(folder.path(), read, true);
    FAIL() << "accepted";
  } catch (const IoError& error) {
    EXPECT_NE(std::string(error.what()).find("run without --resume"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace feder::experiments
