#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/mass_properties.h"
#include "models/scene_file/entries.h"
#include "models/scene_file/scene.h"

namespace feder {

/// A body as a file describes it: mass properties and, where it has one, a surface to look at.
struct BodyShape {
  MassProperties properties;
  SceneSurface surface;
};

/// Makes shapes of the keys a body or part has. What is missing, left over or wrong is told; then nothing is
/// returned.
class ShapeReader {
 public:
  /// Mesh files are looked for in `folder` and, unless allowed, nowhere outside it.
  ShapeReader(std::filesystem::path folder, bool allow_outside, Diagnostics& problems)
      : folder_(std::move(folder)), allow_outside_(allow_outside), problems_(problems) {}

  std::optional<BodyShape> read(const std::string& label, TextPlace place, const ShapeKeys& keys,
                                const std::vector<PartEntry>& parts);

 private:
  bool check_keys_of_kind(const std::string& label, TextPlace place, const ShapeKeys& keys, bool has_parts);
  std::optional<BodyShape> read_mesh_shape(const std::string& label, const ShapeKeys& keys);
  std::optional<BodyShape> read_parts(const std::string& label, const std::vector<PartEntry>& parts);
  std::optional<std::filesystem::path> inside(const std::string& label, const NameText& file);

  std::filesystem::path folder_;
  bool allow_outside_;
  Diagnostics& problems_;
};

}  // namespace feder
