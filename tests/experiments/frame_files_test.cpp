// What a folder holds while frames are written, after a failure, and after going on from a checkpoint.
#include "experiments/support/frame_files.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <set>

#include "engine/check.h"
#include "tests/experiments/file_size_limit.h"
#include "tests/experiments/frame_sample.h"
#include "tests/experiments/temporary_folder.h"

namespace feder::experiments {
namespace {

std::set<std::string> names(const std::filesystem::path& folder) {
  std::set<std::string> found;
  for (const auto& [name, text] : contents(folder)) found.insert(name);
  return found;
}

Checkpoint checkpoint_of(FrameFiles& files) {
  Checkpoint checkpoint;
  checkpoint.frame = files.frames();
  checkpoint.files = files.positions();
  return checkpoint;
}

TEST(FrameFiles, GiveFinalNamesOnlyWhenFinished) {
  const TemporaryFolder folder;
  const Scene scene = sample_scene();
  FrameFiles files(scene, 2, folder.path(), kEveryFile);
  add_frames(files, scene, 0, 1);
  EXPECT_EQ(names(folder.path()),
            (std::set<std::string>{"energy.csv.part", "frames/frame_000000.vtu", "rows.csv.part",
                                   "sample_1_2.pvd.part", "states.csv.part", "trajectory.csv.part",
                                   "trajectory.npy.part"}));
  files.finish();
  EXPECT_EQ(names(folder.path()),
            (std::set<std::string>{"energy.csv", "frames/frame_000000.vtu", "rows.csv", "sample_1_2.pvd",
                                   "states.csv", "trajectory.csv", "trajectory.npy"}));
}

TEST(FrameFiles, WriteOnlyWhatWasAsked) {
  const TemporaryFolder folder;
  const Scene scene = sample_scene();
  FrameFiles files(scene, 1, folder.path(), {.states = false, .energy = true});
  add_frames(files, scene, 0, 1);
  files.finish();
  EXPECT_EQ(names(folder.path()), std::set<std::string>{"energy.csv"});
}

TEST(FrameFiles, AreTheSameHoweverManyFramesWerePlanned) {
  const TemporaryFolder one, other;
  const Scene scene = sample_scene();
  for (const auto& [folder, planned] : {std::pair{one.path(), 5}, {other.path(), 5000}}) {
    FrameFiles files(scene, planned, folder, kEveryFile);
    add_frames(files, scene, 0, 5);
    files.finish();
  }
  EXPECT_EQ(difference(contents(one.path()), contents(other.path())), "");
}

TEST(FrameFiles, RemoveLaterFramesOfAnEarlierRun) {
  const TemporaryFolder folder, expected;
  const Scene scene = sample_scene();
  write_sample(scene, 9, folder.path());
  write_sample(scene, 4, folder.path());
  write_sample(scene, 4, expected.path());
  EXPECT_EQ(difference(contents(expected.path()), contents(folder.path())), "");
}

TEST(FrameFiles, RefuseFramesOutOfOrder) {
  const TemporaryFolder folder;
  const Scene scene = sample_scene();
  FrameFiles files(scene, 2, folder.path(), kEveryFile);
  const State state = sample_state(scene, 0);
  EXPECT_THROW(files.add(1, state, {}), MisuseError);
  add_frames(files, scene, 0, 2);
  EXPECT_THROW(files.add(2, state, {}), MisuseError);  // not planned
  files.finish();
  EXPECT_THROW((void)files.positions(), MisuseError);
}

TEST(FrameFiles, RefuseASceneThatPointsBeyondItsModel) {
  const TemporaryFolder folder;
  const auto refused = [&](auto&& change) {
    Scene scene = sample_scene();
    change(scene);
    EXPECT_THROW(FrameFiles(scene, 1, folder.path(), kEveryFile), MisuseError);
  };
  refused([](Scene& s) { s.nodes[0].node = s.model.system.places(); });
  refused([](Scene& s) { s.nodes[0].body = 0; });
  refused([](Scene& s) { s.rows[0].first_row = s.model.system.rows; });
  refused([](Scene& s) { s.rows[0].nodes[1] = {.body = 2}; });
  refused([](Scene& s) { s.surfaces[0].triangles[0][2] = 4; });
  EXPECT_TRUE(names(folder.path()).empty());
}

TEST(FrameFiles, KeepWholeFramesWhenTheDiskIsFull) {
  const Scene scene = sample_scene();
  std::set<std::int64_t> counts;
  for (const rlim_t limit : {3000, 3500, 5500, 7000, 9000, 11000, 15000}) {
    const TemporaryFolder folder, expected;
    FrameFiles files(scene, kSampleFrames, folder.path(), kEveryFile);
    {
      const FileSizeLimit full(limit);
      EXPECT_THROW(add_frames(files, scene, 0, kSampleFrames), IoError);
    }
    counts.insert(files.frames());
    files.finish();
    write_sample(scene, files.frames(), expected.path());
    EXPECT_EQ(difference(contents(expected.path()), contents(folder.path())), "") << limit;
  }
  EXPECT_EQ(counts.size(), 7u);  // from 0, where the first vtu does not fit, to 9
}

TEST(FrameFiles, LeaveTheFilesOfAnEarlierRunWhenTheDiskIsFull) {
  const TemporaryFolder folder;
  const Scene scene = sample_scene();
  const FrameOptions options{.states = true, .trajectory_npy = true};
  {
    FrameFiles files(scene, 3, folder.path(), options);
    add_frames(files, scene, 0, 3);
    files.finish();
  }
  const auto before = contents(folder.path());
  {
    FrameFiles files(scene, kSampleFrames, folder.path(), options);
    const FileSizeLimit full(2000);
    EXPECT_THROW(add_frames(files, scene, 0, kSampleFrames), IoError);
  }
  const auto after = contents(folder.path());
  for (const auto& [name, text] : before) EXPECT_TRUE(after.at(name) == text) << name;
}

TEST(FrameFiles, FinishAgainAfterAFullDisk) {
  const TemporaryFolder folder, expected;
  const Scene scene = sample_scene();
  FrameFiles files(scene, kSampleFrames, folder.path(), kEveryFile);
  add_frames(files, scene, 0, 3);
  const auto length = std::filesystem::file_size(folder.path() / "sample_1_2.pvd.part");
  {
    const FileSizeLimit full(length + 5);
    EXPECT_THROW(files.finish(), IoError);
  }
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "states.csv"));
  files.finish();
  write_sample(scene, 3, expected.path());
  EXPECT_EQ(difference(contents(expected.path()), contents(folder.path())), "");
}

/// Makes every later write of this process to the file fail, as if it had been closed.
void break_file(const std::filesystem::path& path) {
  const int nothing = ::open("/dev/null", O_RDONLY);
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code error;
    if (std::filesystem::read_symlink(entry.path(), error) == path)
      ::dup2(nothing, std::stoi(entry.path().filename().string()));
  }
  ::close(nothing);
}

TEST(FrameFiles, SayAtOnceThatAFileCannotBeWritten) {
  const TemporaryFolder folder;
  const Scene scene = sample_scene();
  FrameFiles files(scene, kSampleFrames, folder.path(), kEveryFile);
  add_frames(files, scene, 0, 2);
  break_file(std::filesystem::canonical(folder.path()) / "states.csv.part");
  try {
    add_frames(files, scene, 2, 3);
    FAIL() << "nothing was thrown";
  } catch (const IoError& error) {
    EXPECT_NE(std::string(error.what()).find("states.csv.part"), std::string::npos) << error.what();
  }
  EXPECT_THROW(files.finish(), IoError);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "states.csv"));
}

/// Runs that stop at a random frame, some frames after their checkpoint, and go on: their files are those of
/// the run that never stopped.
void stop_and_go_on(std::uint64_t first_seed, bool finish) {
  const Scene scene = sample_scene();
  const TemporaryFolder expected;
  write_sample(scene, kSampleFrames, expected.path());
  const auto expected_contents = contents(expected.path());
  for (std::uint64_t seed = first_seed; seed < first_seed + 15; ++seed) {
    const TemporaryFolder folder;
    Random random(seed);
    const int stop = random.below(kSampleFrames + 1),
              lost = random.below(static_cast<int>(kSampleFrames) - stop + 1);
    Checkpoint checkpoint;
    {
      FrameFiles files(scene, kSampleFrames, folder.path(), kEveryFile);
      add_frames(files, scene, 0, stop);
      checkpoint = checkpoint_of(files);
      add_frames(files, scene, stop, stop + lost);
      if (finish) files.finish();
    }
    FrameFiles files(scene, kSampleFrames, folder.path(), kEveryFile, checkpoint);
    EXPECT_EQ(files.frames(), stop);
    add_frames(files, scene, stop, kSampleFrames);
    files.finish();
    EXPECT_EQ(difference(expected_contents, contents(folder.path())), "") << stop << " + " << lost;
  }
}

TEST(FrameFiles, GoOnBitwiseAfterAKill) {
  stop_and_go_on(0, false);
}

TEST(FrameFiles, GoOnBitwiseAfterAFinishedInterrupt) {
  stop_and_go_on(100, true);
}

TEST(FrameFiles, ForgetWhatCameAfterTheCheckpoint) {
  const TemporaryFolder folder, expected;
  const Scene scene = sample_scene();
  Checkpoint checkpoint;
  {
    FrameFiles files(scene, kSampleFrames, folder.path(), kEveryFile);
    add_frames(files, scene, 0, 4);
    checkpoint = checkpoint_of(files);
    add_frames(files, scene, 4, 10);
  }
  FrameFiles files(scene, kSampleFrames, folder.path(), kEveryFile, checkpoint);
  add_frames(files, scene, 4, 6);
  files.finish();
  write_sample(scene, 6, expected.path());
  EXPECT_EQ(difference(contents(expected.path()), contents(folder.path())), "");
}

/// The message of the IoError of going on with `checkpoint`, and that nothing was changed.
std::string refusal(const Scene& scene, const std::filesystem::path& folder, const Checkpoint& checkpoint) {
  const auto before = contents(folder);
  std::string message = "nothing was thrown";
  try {
    const FrameFiles files(scene, kSampleFrames, folder, kEveryFile, checkpoint);
  } catch (const IoError& error) {
    message = error.what();
  }
  EXPECT_EQ(difference(before, contents(folder)), "");
  return message;
}

TEST(FrameFiles, DoNotGoOnWithoutTheirFiles) {
  const TemporaryFolder folder;
  const Scene scene = sample_scene();
  Checkpoint checkpoint;
  {
    FrameFiles files(scene, kSampleFrames, folder.path(), kEveryFile);
    add_frames(files, scene, 0, 4);
    checkpoint = checkpoint_of(files);
  }
  const std::filesystem::path rows = folder.path() / "rows.csv.part",
                              vtu = folder.path() / "frames/frame_000003.vtu";
  const auto length = std::filesystem::file_size(rows), vtu_length = std::filesystem::file_size(vtu);

  std::filesystem::resize_file(rows, length - 1);
  EXPECT_EQ(refusal(scene, folder.path(), checkpoint),
            "'" + rows.string() + "' has " + std::to_string(length - 1) + " bytes, expected at least " +
                std::to_string(length) + " bytes to continue it");
  std::filesystem::remove(rows);
  EXPECT_EQ(refusal(scene, folder.path(), checkpoint),
            "neither '" + rows.string() + "' nor '" + (folder.path() / "rows.csv").string() +
                "' is there, expected at least " + std::to_string(length) + " bytes to continue it");
  write_file(rows, std::string(length, 'x'));
  std::filesystem::resize_file(vtu, 10);
  EXPECT_EQ(refusal(scene, folder.path(), checkpoint),
            "'" + vtu.string() + "' has 10 bytes, expected a frame of " + std::to_string(vtu_length) +
                " bytes to continue after it");
}

TEST(FrameFiles, DoNotGoOnWithOtherOptions) {
  const TemporaryFolder folder;
  const Scene scene = sample_scene();
  FrameFiles files(scene, kSampleFrames, folder.path(), {.states = true, .energy = false});
  add_frames(files, scene, 0, 4);
  EXPECT_THROW(FrameFiles(scene, kSampleFrames, folder.path(), {}, checkpoint_of(files)), InputError);
}

}  // namespace
}  // namespace feder::experiments
