#include "experiments/support/growing_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <utility>

#include "experiments/support/files.h"

namespace feder::experiments {
namespace {

std::filesystem::path part_of(std::filesystem::path path) {
  return path += ".part";
}

}  // namespace

GrowingFile::GrowingFile(std::filesystem::path path)
    : path_(std::move(path)), part_(part_of(path_)), file_(part_, O_WRONLY | O_CREAT | O_TRUNC) {
  if (file_.id() < 0) fail_io("cannot create", part_, errno);
}

GrowingFile::GrowingFile(std::filesystem::path path, std::int64_t length)
    : path_(std::move(path)), part_(part_of(path_)), file_(part_, O_WRONLY) {
  if (file_.id() < 0) {
    if (errno != ENOENT) fail_io("cannot open", part_, errno);
    rename_file(path_, part_);
    file_ = Descriptor(part_, O_WRONLY);
    if (file_.id() < 0) fail_io("cannot open", part_, errno);
  }
  shorten(length);
}

void GrowingFile::require_at_least(const std::filesystem::path& path, std::int64_t length) {
  const std::string expected = ", expected at least " + std::to_string(length) + " bytes to continue it";
  std::error_code error;
  std::filesystem::path found = part_of(path);
  if (!std::filesystem::exists(found, error)) found = path;
  if (!std::filesystem::is_regular_file(found, error))
    throw IoError("neither '" + part_of(path).string() + "' nor '" + path.string() + "' is there" + expected);
  const auto size = std::filesystem::file_size(found, error);
  if (error) fail_io("cannot read the length of", found, error.value());
  if (size < static_cast<std::uintmax_t>(length))
    throw IoError("'" + found.string() + "' has " + std::to_string(size) + " bytes" + expected);
}

void GrowingFile::append(std::string_view text) {
  write_all(file_, text, length_, part_);
  length_ += static_cast<std::int64_t>(text.size());
}

void GrowingFile::overwrite_start(std::string_view text) {
  write_all(file_, text, 0, part_);
}

void GrowingFile::shorten(std::int64_t length) {
  if (::ftruncate(file_.id(), length) != 0) fail_io("cannot shorten", part_, errno);
  length_ = length;
}

void GrowingFile::sync() {
  if (::fsync(file_.id()) != 0) fail_io("cannot write", part_, errno);
}

void GrowingFile::take_final_name() {
  if (complete_) return;
  rename_file(part_, path_);
  complete_ = true;
}

}  // namespace feder::experiments
