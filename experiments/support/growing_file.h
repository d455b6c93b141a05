#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

#include "experiments/support/descriptor.h"

namespace feder::experiments {

/// A file that grows as `<path>.part` and takes its final name once it is complete. Every function throws
/// IoError where the system refuses.
class GrowingFile {
 public:
  /// A new empty file.
  explicit GrowingFile(std::filesystem::path path);
  /// Continues one at `length` bytes: the .part or, where there is none, the complete file, which becomes
  /// the .part again. Call require_at_least for all files of a run first.
  GrowingFile(std::filesystem::path path, std::int64_t length);
  /// IoError, naming file, length and expectation, if neither file is there or the one to continue is
  /// shorter. Changes nothing.
  static void require_at_least(const std::filesystem::path& path, std::int64_t length);

  const std::filesystem::path& path() const { return path_; }  ///< final name
  std::int64_t length() const { return length_; }              ///< [bytes]

  /// One write. After an error the end of the file is unknown until shorten().
  void append(std::string_view text);
  void overwrite_start(std::string_view text);
  void shorten(std::int64_t length);
  void sync();
  /// The .part becomes the final file; the caller has synced it. Nothing to do the second time.
  void take_final_name();

 private:
  std::filesystem::path path_, part_;
  std::int64_t length_ = 0;
  bool complete_ = false;
  Descriptor file_;
};

}  // namespace feder::experiments
