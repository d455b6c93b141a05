#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "models/scene_file/entries.h"
#include "models/scene_file/scene.h"

namespace feder {

/// A table of the file that is not physics, read by the caller. `read` is given the table and where to tell
/// its problems, so that they come together with those of the scene; `check`, if there is one, looks at it
/// again once the end time is known.
struct OtherTable {
  std::string name;
  std::function<void(const Value& table, Diagnostics& problems)> read;
  std::function<void(double end_time, Diagnostics& problems)> check = {};
};

/// How a scene file is read.
struct SceneOptions {
  std::vector<std::string> changes = {};  ///< of --set: "spring.rope.stiffness=1e5", applied before checking
  std::vector<OtherTable> others = {};
  bool quick = false;          ///< end at quick_end_time where the file has one
  bool allow_outside = false;  ///< mesh files may lie outside the scene's folder
  double most_nodes = kMaxNodes, most_rows = kMaxRows;
};

/// A scene and what its file says beside the physics.
struct SceneFile {
  Scene scene;
  std::string title;
  std::vector<std::string> notes;  ///< what is no error but will surprise, one sentence each
};

/// Reads a scene. Throws SceneError (an InputError) with every problem found, one line each:
/// "file:line:column: what = value, expected ...", at most 20; InputError where the file cannot be read.
/// Nothing is allocated in proportion to a count before it is checked.
SceneFile read_scene(const std::filesystem::path& file, const SceneOptions& options = {});
/// The bytes of a scene file. InputError if it cannot be read or is too large.
std::string read_scene_bytes(const std::filesystem::path& file);
/// The same from text; `name` stands for the file in messages, `folder` is where mesh files are looked for.
SceneFile read_scene_text(const std::string& text, const std::string& name,
                          const std::filesystem::path& folder, const SceneOptions& options = {});

/// The reference page: every table and key with unit, default and meaning, as Markdown. `others` are the
/// caller's tables.
std::string scene_reference(const std::vector<TableInfo>& others);

}  // namespace feder
