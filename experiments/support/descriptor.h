#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace feder::experiments {

/// Throws IoError: "<what> '<path>': <text of errno>".
[[noreturn]] void fail_io(const std::string& what, const std::filesystem::path& path, int error);

/// Owns a file descriptor, so that no error path leaks it.
class Descriptor {
 public:
  Descriptor(const std::filesystem::path& path, int flags);  ///< id() < 0 and errno set where open fails
  ~Descriptor();
  Descriptor(Descriptor&& other) noexcept;
  Descriptor& operator=(Descriptor&& other) noexcept;

  int id() const { return id_; }
  bool close();  ///< false with errno set

 private:
  int id_;
};

/// All of the text at `offset` of the file; `path` is for the message of an IoError.
void write_all(const Descriptor& file, std::string_view text, std::int64_t offset,
               const std::filesystem::path& path);

}  // namespace feder::experiments
