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

/// The same without waiting for the disk: whole or old for every reader, but after a power cut only once
/// sync_file(path) and sync_folder have returned. Throws IoError.
void write_file_unsynced(const std::filesystem::path& path, std::string_view text);

/// Waits until the file is on disk. Throws IoError.
void sync_file(const std::filesystem::path& path);

/// Waits until the names in a folder are on disk, where the file system offers that.
void sync_folder(const std::filesystem::path& folder);

/// Replaces `to` if it exists. Throws IoError.
void rename_file(const std::filesystem::path& from, const std::filesystem::path& to);

/// Makes a file that another program wrote under `temporary` durable and moves it to `path`. Throws IoError.
void commit_file(const std::filesystem::path& temporary, const std::filesystem::path& path);

/// The whole file. Throws IoError.
std::string read_file(const std::filesystem::path& path);

/// Removes the file if there is one. Throws IoError.
void remove_file(const std::filesystem::path& path);

/// Creates the folder and its parents. Throws IoError.
void create_folder(const std::filesystem::path& folder);

}  // namespace feder::experiments
