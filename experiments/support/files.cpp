#include "experiments/support/files.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <system_error>

#include "experiments/support/descriptor.h"

namespace feder::experiments {
namespace {

std::filesystem::path temporary_beside(const std::filesystem::path& path) {
  std::filesystem::path temporary = path;
  temporary += ".tmp" + std::to_string(::getpid());
  return temporary;
}

void replace_file(const std::filesystem::path& path, std::string_view text, bool durable) {
  const std::filesystem::path temporary = temporary_beside(path);
  try {
    Descriptor file(temporary, O_WRONLY | O_CREAT | O_TRUNC);
    if (file.id() < 0) fail_io("cannot create", path, errno);
    write_all(file, text, 0, path);
    if (!file.close()) fail_io("cannot close", path, errno);
    if (durable)
      commit_file(temporary, path);
    else
      rename_file(temporary, path);
  } catch (...) {
    ::unlink(temporary.c_str());
    throw;
  }
}

}  // namespace

void write_file(const std::filesystem::path& path, std::string_view text) {
  replace_file(path, text, true);
}

void write_file_unsynced(const std::filesystem::path& path, std::string_view text) {
  replace_file(path, text, false);
}

void sync_file(const std::filesystem::path& path) {
  Descriptor file(path, O_RDONLY);
  if (file.id() < 0 || ::fsync(file.id()) != 0) fail_io("cannot write", path, errno);
}

void sync_folder(const std::filesystem::path& folder) {
  Descriptor directory(folder.empty() ? "." : folder, O_RDONLY | O_DIRECTORY);
  if (directory.id() >= 0) ::fsync(directory.id());
}

void rename_file(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (std::rename(from.c_str(), to.c_str()) != 0) fail_io("cannot rename to", to, errno);
}

void commit_file(const std::filesystem::path& temporary, const std::filesystem::path& path) {
  // The text must be on disk before its name is, or a power cut could leave an empty file there.
  sync_file(temporary);
  rename_file(temporary, path);
  sync_folder(path.parent_path());
}

std::string read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) fail_io("cannot read", path, errno);
  std::ostringstream text;
  text << file.rdbuf();
  if (file.bad()) fail_io("cannot read", path, errno);
  return text.str();
}

void remove_file(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::remove(path, error);
  if (error) fail_io("cannot remove", path, error.value());
}

void create_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder, error)) {
    throw IoError("cannot create the folder '" + folder.string() +
                  "': " + (error ? error.message() : "not a folder"));
  }
}

}  // namespace feder::experiments
