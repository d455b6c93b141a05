#include "experiments/support/files.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

namespace feder::experiments {
namespace {

[[noreturn]] void fail(const std::string& what, const std::filesystem::path& path, int error) {
  throw IoError(what + " '" + path.string() + "': " + std::generic_category().message(error));
}

/// Owns a file descriptor, so that no error path leaks it.
class Descriptor {
 public:
  Descriptor(const std::filesystem::path& path, int flags)
      : id_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {}
  ~Descriptor() {
    if (id_ >= 0) ::close(id_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  int id() const { return id_; }
  bool close() { return ::close(std::exchange(id_, -1)) == 0; }

 private:
  int id_;
};

void write_all(int id, std::string_view text, const std::filesystem::path& path) {
  while (!text.empty()) {
    const ssize_t written = ::write(id, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail("cannot write", path, errno);
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

std::filesystem::path temporary_beside(const std::filesystem::path& path) {
  std::filesystem::path temporary = path;
  temporary += ".tmp" + std::to_string(::getpid());
  return temporary;
}

}  // namespace

void write_file(const std::filesystem::path& path, std::string_view text) {
  const std::filesystem::path temporary = temporary_beside(path);
  try {
    Descriptor file(temporary, O_WRONLY | O_CREAT | O_TRUNC);
    if (file.id() < 0) fail("cannot create", path, errno);
    write_all(file.id(), text, path);
    if (!file.close()) fail("cannot close", path, errno);
    commit_file(temporary, path);
  } catch (...) {
    ::unlink(temporary.c_str());
    throw;
  }
}

void commit_file(const std::filesystem::path& temporary, const std::filesystem::path& path) {
  // The text must be on disk before its name is, or a power cut could leave an empty file there.
  {
    Descriptor file(temporary, O_RDONLY);
    if (file.id() < 0 || ::fsync(file.id()) != 0) fail("cannot write", path, errno);
  }
  if (std::rename(temporary.c_str(), path.c_str()) != 0) fail("cannot rename to", path, errno);
  const std::filesystem::path folder =
      path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  Descriptor directory(folder, O_RDONLY | O_DIRECTORY);
  if (directory.id() >= 0) ::fsync(directory.id());
}

std::string read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) fail("cannot read", path, errno);
  std::ostringstream text;
  text << file.rdbuf();
  if (file.bad()) fail("cannot read", path, errno);
  return text.str();
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
