#include "experiments/support/files.h"

#include <gtest/gtest.h>

#include "tests/experiments/file_size_limit.h"
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

TEST(WriteFileUnsynced, ReplacesTheWholeTextOrKeepsIt) {
  const TemporaryFolder folder;
  write_file_unsynced(folder.path() / "a.vtu", "old");
  {
    const FileSizeLimit limit(1000);
    EXPECT_THROW(write_file_unsynced(folder.path() / "a.vtu", std::string(5000, 'x')), IoError);
  }
  EXPECT_EQ(read_file(folder.path() / "a.vtu"), "old");
  write_file_unsynced(folder.path() / "a.vtu", "new");
  EXPECT_EQ(read_file(folder.path() / "a.vtu"), "new");
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
