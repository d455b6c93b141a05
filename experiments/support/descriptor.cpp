#include "experiments/support/descriptor.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "experiments/support/files.h"

namespace feder::experiments {

void fail_io(const std::string& what, const std::filesystem::path& path, int error) {
  throw IoError(what + " '" + path.string() + "': " + std::generic_category().message(error));
}

Descriptor::Descriptor(const std::filesystem::path& path, int flags)
    : id_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {}

Descriptor::~Descriptor() {
  if (id_ >= 0) ::close(id_);
}

Descriptor::Descriptor(Descriptor&& other) noexcept : id_(std::exchange(other.id_, -1)) {}

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  std::swap(id_, other.id_);
  return *this;
}

bool Descriptor::close() {
  return ::close(std::exchange(id_, -1)) == 0;
}

void write_all(const Descriptor& file, std::string_view text, std::int64_t offset,
               const std::filesystem::path& path) {
  while (!text.empty()) {
    const ssize_t written = ::pwrite(file.id(), text.data(), text.size(), offset);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail_io("cannot write", path, errno);
    text.remove_prefix(static_cast<std::size_t>(written));
    offset += written;
  }
}

}  // namespace feder::experiments
