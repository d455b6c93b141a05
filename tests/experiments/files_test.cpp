#include "experiments/support/files.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>

#include "tests/experiments/temporary_folder.h"

namespace feder::experiments {
namespace {

std::size_t number_of_files(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST(WriteFile, ReplacesTheWholeText) {
  const TemporaryFolder folder;
  write_file(folder.path() / "a.csv", "a long first text");
  write_file(folder.path() / "a.csv", "second");
  EXPECT_EQ(read_file(folder.path() / "a.csv"), "second");
  EXPECT_EQ(number_of_files(folder.path()), 1u);
}

TEST(WriteFile, NamesTheMissingFolder) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "missing" / "a.csv";
  try {
    write_file(path, "text");
    FAIL() << "nothing was thrown";
  } catch (const IoError& error) {
    EXPECT_NE(std::string(error.what()).find(path.string()), std::string::npos) << error.what();
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

/// While it lives, files of this process cannot grow beyond `bytes`: what a full disk looks like to a
/// program.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &old_);
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, old_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &old_);
    std::signal(SIGXFSZ, SIG_DFL);
  }

 private:
  rlimit old_{};
};

TEST(WriteFile, KeepsTheOldFileWhenTheDiskIsFull) {
  const TemporaryFolder folder;
  write_file(folder.path() / "a.csv", "old");
  {
    const FileSizeLimit limit(1000);
    EXPECT_THROW(write_file(folder.path() / "a.csv", std::string(5000, 'x')), IoError);
  }
  EXPECT_EQ(read_file(folder.path() / "a.csv"), "old");
  EXPECT_EQ(number_of_files(folder.path()), 1u);
}

TEST(WriteFile, LeavesNothingWhenTheNameIsTaken) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "a.csv");
  EXPECT_THROW(write_file(folder.path() / "a.csv", "text"), IoError);
  EXPECT_EQ(number_of_files(folder.path()), 1u);
}

TEST(CreateFolder, RefusesAFileInTheWay) {
  const TemporaryFolder folder;
  write_file(folder.path() / "file", "");
  EXPECT_THROW(create_folder(folder.path() / "file" / "below"), IoError);
  EXPECT_THROW(create_folder(folder.path() / "file"), IoError);
  EXPECT_NO_THROW(create_folder(folder.path() / "a" / "b"));
  EXPECT_NO_THROW(create_folder(folder.path() / "a" / "b"));
}

TEST(ReadFile, NamesTheMissingFile) {
  EXPECT_THROW((void)read_file("/no/such/file"), IoError);
}

}  // namespace
}  // namespace feder::experiments
