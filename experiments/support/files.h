#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>

namespace feder::experiments {

/// A file could not be read or written. Programs turn it into exit code 4.
class IoError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Writes through a temporary file in the same folder (flush, fsync, rename): `path` holds the old text or
/// all of the new text, never a part of it. Throws IoError.
void write_file(const std::filesystem::path& path, std::string_view text);

/// Makes a file that another program wrote under `temporary` durable and moves it to `path`. Throws IoError.
void commit_file(const std::filesystem::path& temporary, const std::filesystem::path& path);

/// The whole file. Throws IoError.
std::string read_file(const std::filesystem::path& path);

/// Creates the folder and its parents. Throws IoError.
void create_folder(const std::filesystem::path& folder);

}  // namespace feder::experiments
