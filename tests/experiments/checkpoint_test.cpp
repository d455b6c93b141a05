#include "experiments/support/checkpoint.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "engine/check.h"
#include "tests/experiments/file_size_limit.h"
#include "tests/experiments/frame_sample.h"
#include "tests/experiments/temporary_folder.h"

namespace feder::experiments {
namespace {

Checkpoint sample_checkpoint(const Scene& scene = sample_scene()) {
  Checkpoint checkpoint{0xfedcba9876543210u,
                        7,
                        123456789012,
                        sample_state(scene, 7),
                        sample_history(scene, 7),
                        {{"states.csv", 1000}, {"trajectory.npy", 5'000'000'000}}};
  checkpoint.state.q[0] = -0.0;
  checkpoint.state.q[1] = 5e-324;
  checkpoint.state.q[2] = std::numeric_limits<double>::max();
  return checkpoint;
}

std::string bytes_of(const Checkpoint& checkpoint) {
  const TemporaryFolder folder;
  write_checkpoint(folder.path() / "checkpoint", checkpoint);
  return read_file(folder.path() / "checkpoint");
}

bool same(const VectorXd& a, const VectorXd& b) {
  return a.size() == b.size() &&
         (a.size() == 0 || std::memcmp(a.data(), b.data(), 8 * static_cast<std::size_t>(a.size())) == 0);
}

void put(std::string& bytes, std::size_t at, std::uint64_t value) {
  std::memcpy(bytes.data() + at, &value, 8);
}

/// The same with the size and the checksum it should have.
std::string sealed(std::string bytes) {
  put(bytes, 8, bytes.size());
  std::uint64_t hash = 14695981039346656037ULL;
  for (std::size_t i = 0; i + 8 < bytes.size(); ++i)
    hash = (hash ^ static_cast<unsigned char>(bytes[i])) * 1099511628211ULL;
  put(bytes, bytes.size() - 8, hash);
  return bytes;
}

std::string refusal(const std::string& bytes) {
  try {
    (void)parse_checkpoint(bytes, "run.checkpoint");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Checkpoint, ComesBackBitwise) {
  const TemporaryFolder folder;
  const Checkpoint written = sample_checkpoint();
  write_checkpoint(folder.path() / "checkpoint", written);
  const Checkpoint read = read_checkpoint(folder.path() / "checkpoint");
  EXPECT_EQ(read.scene_hash, written.scene_hash);
  EXPECT_EQ(read.frame, written.frame);
  EXPECT_EQ(read.step, written.step);
  EXPECT_EQ(read.state.t, written.state.t);
  EXPECT_TRUE(same(read.state.q, written.state.q));
  EXPECT_TRUE(same(read.state.v, written.state.v));
  EXPECT_TRUE(same(read.history.lambda, written.history.lambda));
  EXPECT_TRUE(same(read.history.force, written.history.force));
  EXPECT_EQ(read.history.suggested_dt, written.history.suggested_dt);
  EXPECT_EQ(read.history.last_dt, written.history.last_dt);
  EXPECT_TRUE(same(read.history.contacts, written.history.contacts));
  ASSERT_EQ(read.files.size(), 2u);
  EXPECT_EQ(read.files[1].name, "trajectory.npy");
  EXPECT_EQ(read.files[1].length, 5'000'000'000);
}

TEST(Checkpoint, ComesBackFromBeforeTheFirstStep) {
  const Scene scene = sample_scene();
  const Checkpoint read = parse_checkpoint(bytes_of({.state = scene.model.state}), "checkpoint");
  EXPECT_EQ(read.history.lambda.size(), 0);
  EXPECT_EQ(read.history.force.size(), 0);
  EXPECT_TRUE(read.files.empty());
}

TEST(Checkpoint, IsRefusedAfterAnyTruncation) {
  const std::string bytes = bytes_of(sample_checkpoint());
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const auto size = static_cast<std::size_t>(random.below(static_cast<int>(bytes.size())));
    EXPECT_TRUE(refusal(bytes.substr(0, size)).starts_with("run.checkpoint: byte ")) << size;
  }
}

TEST(Checkpoint, IsRefusedAfterAnyBitFlip) {
  const std::string bytes = bytes_of(sample_checkpoint());
  for (std::size_t i = 0; i < 8 * bytes.size(); ++i) {
    std::string flipped = bytes;
    flipped[i / 8] = static_cast<char>(flipped[i / 8] ^ (1 << i % 8));
    ASSERT_TRUE(refusal(flipped).starts_with("run.checkpoint: byte ")) << "bit " << i;
  }
}

TEST(Checkpoint, NamesTheByteTheValueAndWhatItExpected) {
  const std::string bytes = bytes_of(sample_checkpoint());
  const std::size_t size = bytes.size(), v_at = 56 + 8 * sample_checkpoint().state.q.size();
  const auto with = [&](std::size_t at, std::uint64_t value) {
    std::string changed = bytes;
    put(changed, at, value);
    return refusal(sealed(changed));
  };
  EXPECT_EQ(refusal("t,name\n"),
            "run.checkpoint: byte 0: the first of 7 bytes are no checkpoint's, expected 'FEDERCP2'");
  EXPECT_EQ(refusal("FEDERCP3" + bytes.substr(8)),
            "run.checkpoint: byte 7: version 51, expected version 50 ('2')");
  EXPECT_EQ(refusal("FEDERCP"), "run.checkpoint: byte 7: the end, expected version 50 ('2')");
  EXPECT_EQ(refusal("FEDERCP2abc"), "run.checkpoint: byte 8: 3 bytes left, expected 8 for the file's size");
  EXPECT_EQ(refusal(bytes.substr(0, 100)), "run.checkpoint: byte 8: a file of 100 bytes that says it has " +
                                               std::to_string(size) +
                                               ", expected its size there, and all of it");
  EXPECT_EQ(with(24, static_cast<std::uint64_t>(-7)),
            "run.checkpoint: byte 24: frame = -7, expected 0 or more");
  EXPECT_EQ(with(40, std::bit_cast<std::uint64_t>(std::numeric_limits<double>::quiet_NaN())),
            "run.checkpoint: byte 40: t = nan, expected a finite number");
  EXPECT_EQ(with(64, std::bit_cast<std::uint64_t>(kRigid)),
            "run.checkpoint: byte 64: q = inf, expected a finite number");
  EXPECT_EQ(with(48, 1ull << 60), "run.checkpoint: byte 48: q = 1152921504606846976, expected at most " +
                                      std::to_string((size - 56 - 8) / 8) + ", what " +
                                      std::to_string(size - 56 - 8) + " bytes can hold");
  EXPECT_EQ(with(48, static_cast<std::uint64_t>(-1)), "run.checkpoint: byte 48: q = -1, expected 0 or more");
  EXPECT_TRUE(
      with(v_at, 2).starts_with("run.checkpoint: byte " + std::to_string(v_at) + ": 2 velocities beside"))
      << with(v_at, 2);
  EXPECT_TRUE(refusal(sealed(bytes + "12345678")).ends_with(": 8 bytes left, expected the checksum"));
}

TEST(Checkpoint, WithARightChecksumIsReadAsItStandsOrRefused) {
  const Checkpoint checkpoint = sample_checkpoint();
  const std::string bytes = bytes_of(checkpoint);
  Random random(2);
  int accepted = 0, refused = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::string changed = bytes;
    for (int k = random.below(3); k >= 0; --k) {
      const auto at = static_cast<std::size_t>(random.below(static_cast<int>(changed.size())));
      if (random.below(4) == 0)
        changed.erase(at, static_cast<std::size_t>(random.below(20)));
      else
        changed[at] = static_cast<char>(random.bits());
    }
    if (changed.size() < 16) continue;
    changed = sealed(changed);
    try {
      const Checkpoint read = parse_checkpoint(changed, "fuzz");
      ++accepted;
      if (accepted % 100 == 0) EXPECT_TRUE(bytes_of(read) == changed);
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(accepted, 1000);
  EXPECT_GT(refused, 1000);
}

TEST(Checkpoint, RefusesToWriteWhatCouldNotBeRead) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "checkpoint";
  write_checkpoint(path, sample_checkpoint());
  const std::string before = read_file(path);
  Checkpoint bad = sample_checkpoint();
  bad.history.force[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(write_checkpoint(path, bad), MisuseError);
  bad = sample_checkpoint();
  bad.files.push_back(bad.files.front());
  EXPECT_THROW(write_checkpoint(path, bad), MisuseError);
  EXPECT_TRUE(read_file(path) == before);
}

TEST(Checkpoint, KeepsTheLastOneWhenTheDiskIsFull) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "checkpoint";
  write_checkpoint(path, sample_checkpoint());
  const std::string before = read_file(path);
  {
    const FileSizeLimit full(500);
    EXPECT_THROW(write_checkpoint(path, sample_checkpoint()), IoError);
  }
  EXPECT_TRUE(read_file(path) == before);
}

TEST(Checkpoint, BelongsToOneSceneAlone) {
  const Scene scene = sample_scene();
  const Checkpoint checkpoint = sample_checkpoint(scene);
  const auto check = [&](const Checkpoint& given, std::uint64_t hash) {
    require_checkpoint_of(scene, hash, given, "run.checkpoint");
  };
  EXPECT_NO_THROW(check(checkpoint, checkpoint.scene_hash));
  EXPECT_THROW(check(checkpoint, 1), InputError);
  for (VectorXd* (*part)(Checkpoint&) :
       {+[](Checkpoint& c) { return &c.state.q; }, +[](Checkpoint& c) { return &c.state.v; },
        +[](Checkpoint& c) { return &c.history.lambda; }, +[](Checkpoint& c) { return &c.history.force; }}) {
    Checkpoint other = checkpoint;
    part(other)->conservativeResize(part(other)->size() - 3);
    EXPECT_THROW(check(other, checkpoint.scene_hash), InputError);
  }
}

}  // namespace
}  // namespace feder::experiments
