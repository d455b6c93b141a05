#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "experiments/support/checkpoint.h"
#include "models/scene_file/scene.h"

namespace feder::experiments {

/// Which files a run writes.
struct FrameOptions {
  bool states = true;           ///< states.csv
  bool trajectory_csv = false;  ///< trajectory.csv
  bool trajectory_npy = false;  ///< trajectory.npy
  bool rows = false;            ///< rows.csv
  bool energy = true;           ///< energy.csv
  bool vtu = false;             ///< frames/frame_000000.vtu ... and <scene>.pvd
};

/// The frames of a run as files in a folder. All but the vtu grow as `<name>.part`, one write per frame, and
/// get their names in finish(): a file under its final name is whole. Vtu frames are whole at once, on disk
/// after positions() or finish().
///
/// Every function throws IoError where the system refuses. The frame of a failed add() is in no growing
/// file, so that finish() can still keep the frames before it.
class FrameFiles {
 public:
  /// Starts anew in a folder that exists. At most `frames` frames. The scene must outlive the object;
  /// MisuseError where its names point beyond its model.
  FrameFiles(const Scene& scene, std::int64_t frames, const std::filesystem::path& folder,
             const FrameOptions& options);
  /// Goes on behind the frames of a checkpoint: cuts the files to what they were then, and the end is bitwise
  /// that of a run that never stopped. Takes the .part files or else those an interrupted run had finished.
  /// IoError, before any is touched, for a file that is missing or too short; InputError for a checkpoint
  /// that was written with other options.
  FrameFiles(const Scene& scene, std::int64_t frames, const std::filesystem::path& folder,
             const FrameOptions& options, const Checkpoint& checkpoint);
  FrameFiles(FrameFiles&&) noexcept;
  FrameFiles& operator=(FrameFiles&&) noexcept;
  /// Without finish() the .part files stay, to be resumed.
  ~FrameFiles();

  /// Frames are added in order, from 0 or the checkpoint's on.
  void add(std::int64_t frame, const State& state, const History& history);
  std::int64_t frames() const;  ///< written so far
  /// Waits until all frames so far are on disk; for Checkpoint::files.
  std::vector<FilePosition> positions();
  /// The same without waiting: for a checkpoint that is written after finish().
  std::vector<FilePosition> lengths() const;
  /// Completes the files with the frames so far and removes vtu frames behind them that an earlier run left.
  /// If it fails it can be called again.
  void finish();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace feder::experiments
