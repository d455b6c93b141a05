#include "experiments/support/frame_files.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <variant>

#include "engine/check.h"
#include "engine/kkt.h"
#include "experiments/support/energy_csv.h"
#include "experiments/support/files.h"
#include "experiments/support/growing_file.h"
#include "experiments/support/pvd.h"
#include "experiments/support/rows_csv.h"
#include "experiments/support/states_csv.h"
#include "experiments/support/trajectory_csv.h"
#include "experiments/support/trajectory_npy.h"
#include "experiments/support/vtu.h"

namespace feder::experiments {
namespace {

/// THE LIST of what grows with the frames.
using Writer = std::variant<StatesCsv, TrajectoryCsv, TrajectoryNpy, RowsCsv, EnergyCsv, Pvd>;

std::vector<Writer> chosen_writers(const Scene& scene, const FrameOptions& options) {
  std::vector<Writer> writers;
  if (options.states) writers.emplace_back(StatesCsv(scene));
  if (options.trajectory_csv) writers.emplace_back(TrajectoryCsv(scene));
  if (options.trajectory_npy) writers.emplace_back(TrajectoryNpy(scene));
  if (options.rows) writers.emplace_back(RowsCsv(scene));
  if (options.energy) writers.emplace_back(EnergyCsv(scene));
  if (options.vtu) writers.emplace_back(Pvd(scene));
  return writers;
}

std::string name_of(const Writer& writer) {
  return std::visit([](const auto& w) { return w.name(); }, writer);
}

std::string start_of(const Writer& writer, std::int64_t frames) {
  return std::visit([&](const auto& w) { return w.start(frames); }, writer);
}

struct Growing {
  Writer writer;
  GrowingFile file;
};

void check_names(const Scene& scene) {
  const System& s = scene.model.system;
  const auto bodies = static_cast<int>(s.bodies.size());
  for (const SceneNode& node : scene.nodes)
    FEDER_CHECK(node.node >= 0 && node.node < s.places() && node.body < bodies &&
                    (node.body < 0 || s.bodies[node.body].centre == node.node),
                "a scene names a node its system does not have");
  for (const SceneRow& row : scene.rows) {
    FEDER_CHECK(row.first_row >= 0 && row.rows > 0 && row.first_row + row.rows <= s.rows,
                "a scene names a row its system does not have");
    for (const Anchor& anchor : row.nodes)
      FEDER_CHECK(
          anchor.body < bodies && (anchor.body >= 0 || (anchor.node >= 0 && anchor.node < s.places())),
          "a row of a scene lies at a place its system does not have");
  }
  for (const SceneSurface& surface : scene.surfaces) {
    FEDER_CHECK(surface.body >= 0 && surface.body < bodies, "a surface of no body");
    for (const auto& triangle : surface.triangles)
      for (const int vertex : triangle)
        FEDER_CHECK(vertex >= 0 && vertex < static_cast<int>(surface.vertices.size()),
                    "a surface has a triangle without vertex");
  }
}

void require_frames(const std::filesystem::path& folder, std::int64_t frames, std::int64_t length) {
  for (std::int64_t i = 0; i < frames; ++i) {
    const std::filesystem::path path = folder / frame_path(i);
    std::error_code error;
    const auto size = std::filesystem::file_size(path, error);
    if (error || size != static_cast<std::uintmax_t>(length))
      throw IoError(
          "'" + path.string() + "' " +
          (error ? "cannot be read (" + error.message() + ")" : "has " + std::to_string(size) + " bytes") +
          ", expected a frame of " + std::to_string(length) + " bytes to continue after it");
  }
}

}  // namespace

struct FrameFiles::Parts {
  const Scene& scene;
  std::filesystem::path folder;
  std::int64_t planned, frames = 0;
  std::int64_t first_unsynced = 0;  ///< vtu frame
  bool needs_phi = false, broken = false;
  bool ended = false, finished = false;  ///< finish(): texts complete, names given
  std::vector<Growing> growing;
  std::optional<VtuFrames> vtu;
  TextBuffer buffer;
  VectorXd phi;

  Parts(const Scene& given, std::int64_t count, std::filesystem::path where, const FrameOptions& options)
      : scene(given), folder(std::move(where)), planned(count), needs_phi(options.rows || options.vtu) {
    check_names(scene);
    FEDER_CHECK(planned >= 0, "a negative number of frames");
    if (options.vtu) vtu.emplace(scene);
  }

  void add_growing(const Frame& frame, Growing& to) {
    buffer.clear();
    std::visit([&](auto& writer) { writer.add(frame, buffer); }, to.writer);
    to.file.append(buffer.text());
  }

  /// Does something with all growing files; if that fails, all are as they were.
  template <class Change>
  void all_or_none(Change&& change) {
    if (broken) throw IoError("the files in '" + folder.string() + "' end in a part of a frame");
    std::vector<std::int64_t> lengths;
    for (const Growing& g : growing) lengths.push_back(g.file.length());
    try {
      change();
    } catch (...) {
      for (std::size_t i = 0; i < growing.size(); ++i) shorten(growing[i].file, lengths[i]);
      throw;
    }
  }

  void shorten(GrowingFile& file, std::int64_t length) {
    try {
      file.shorten(length);
    } catch (const IoError&) {
      broken = true;  // the error that led here is on its way
    }
  }

  void sync() {
    for (Growing& g : growing) g.file.sync();
    for (; vtu && first_unsynced < frames; ++first_unsynced) sync_file(folder / frame_path(first_unsynced));
    if (vtu) sync_folder(folder / "frames");
    sync_folder(folder);
  }

  void remove_later_frames() const {
    std::error_code error;
    std::filesystem::path path = folder / frame_path(frames);
    for (std::int64_t i = frames; std::filesystem::remove(path, error); path = folder / frame_path(++i)) {
    }
    if (error) throw IoError("cannot remove '" + path.string() + "': " + error.message());
  }
};

FrameFiles::FrameFiles(const Scene& scene, std::int64_t frames, const std::filesystem::path& folder,
                       const FrameOptions& options)
    : parts_(std::make_unique<Parts>(scene, frames, folder, options)) {
  if (options.vtu) {
    create_folder(folder / "frames");
    remove_file(folder / Pvd(scene).name());  // an earlier run's: its frames are about to be replaced
  }
  for (Writer& writer : chosen_writers(scene, options)) {
    GrowingFile file(folder / name_of(writer));
    file.append(start_of(writer, frames));
    parts_->growing.push_back({std::move(writer), std::move(file)});
  }
}

FrameFiles::FrameFiles(const Scene& scene, std::int64_t frames, const std::filesystem::path& folder,
                       const FrameOptions& options, const Checkpoint& checkpoint)
    : parts_(std::make_unique<Parts>(scene, frames, folder, options)) {
  FEDER_CHECK(checkpoint.frame <= frames, "a checkpoint behind the last frame");
  std::vector<Writer> writers = chosen_writers(scene, options);
  std::string asked, kept;
  for (const Writer& writer : writers) asked += name_of(writer) + " ";
  for (const FilePosition& file : checkpoint.files) kept += file.name + " ";
  if (asked != kept) throw InputError("checkpoint: of a run that wrote " + kept + ", expected " + asked);

  for (const FilePosition& file : checkpoint.files)
    GrowingFile::require_at_least(folder / file.name, file.length);
  if (parts_->vtu) require_frames(folder, checkpoint.frame, parts_->vtu->length());
  for (std::size_t i = 0; i < writers.size(); ++i) {
    GrowingFile file(folder / checkpoint.files[i].name, checkpoint.files[i].length);
    parts_->growing.push_back({std::move(writers[i]), std::move(file)});
  }
  parts_->frames = parts_->first_unsynced = checkpoint.frame;
}

FrameFiles::FrameFiles(FrameFiles&&) noexcept = default;
FrameFiles& FrameFiles::operator=(FrameFiles&&) noexcept = default;
FrameFiles::~FrameFiles() = default;

std::int64_t FrameFiles::frames() const {
  return parts_->frames;
}

void FrameFiles::add(std::int64_t frame, const State& state, const History& history) {
  Parts& p = *parts_;
  const System& s = p.scene.model.system;
  FEDER_CHECK(!p.ended && frame == p.frames && frame < p.planned, "frames are added in order, as planned");
  FEDER_CHECK(state.q.size() == s.position_size() && state.v.size() == 3 * s.nodes &&
                  (history.lambda.size() == 0 || history.lambda.size() == s.rows),
              "a frame of another system");
  if (p.needs_phi) evaluate_phi(s, state.q, p.phi);
  const Frame shown{frame, state, history, p.phi};
  p.all_or_none([&] {
    if (p.vtu) write_file_unsynced(p.folder / frame_path(frame), p.vtu->text(shown));
    for (Growing& g : p.growing) p.add_growing(shown, g);
  });
  ++p.frames;
}

std::vector<FilePosition> FrameFiles::lengths() const {
  FEDER_CHECK(!parts_->ended, "positions of finished files");
  std::vector<FilePosition> positions;
  for (const Growing& g : parts_->growing) positions.push_back({name_of(g.writer), g.file.length()});
  return positions;
}

std::vector<FilePosition> FrameFiles::positions() {
  std::vector<FilePosition> positions = lengths();
  parts_->all_or_none([&] { parts_->sync(); });
  return positions;
}

void FrameFiles::finish() {
  Parts& p = *parts_;
  if (p.finished) return;
  if (!p.ended)
    p.all_or_none([&] {
      for (Growing& g : p.growing) {
        g.file.append(std::visit([](const auto& writer) { return writer.end(); }, g.writer));
        g.file.overwrite_start(start_of(g.writer, p.frames));
      }
      p.sync();
    });
  p.ended = true;
  for (Growing& g : p.growing) g.file.take_final_name();
  sync_folder(p.folder);
  if (p.vtu) p.remove_later_frames();
  p.finished = true;
}

}  // namespace feder::experiments
