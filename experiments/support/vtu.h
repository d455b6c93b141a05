#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/support/frame.h"
#include "models/scene_file/scene.h"

namespace feder::experiments {

/// Frames as VTK unstructured grids (XML, inline base64, Float64). Points: the SceneNodes, further anchors of
/// SceneRows, the vertices of SceneSurfaces; all with their velocity. Cells: a vertex per node, lines from
/// place to place per row (two for bending), triangles; with row_force (lambda; of three scalar rows its
/// norm), strain (phi / rest length of distance rows) and kind (0 node, 1 row, 2 surface).
///
/// Only the numbers change between frames, so that the text is made once and every frame has equal length.
class VtuFrames {
 public:
  explicit VtuFrames(const Scene& scene);

  /// Valid until the next call.
  std::string_view text(const Frame& frame);
  std::int64_t length() const { return static_cast<std::int64_t>(text_.size()); }  ///< [bytes] of each frame

 private:
  /// Where an array of doubles that changes stands in the text.
  struct Slot {
    std::size_t at = 0, count = 0;
  };
  /// What a line shows.
  struct RowCell {
    int first_row, rows;
    double rest;  ///< [m], 0 where the row has no length
  };
  template <class Number>
  void add_array(const std::string& attributes, const std::vector<Number>& values);
  Slot add_slot(const std::string& attributes, std::size_t count);
  double* fill(const Slot& slot);
  void put(const Slot& slot);

  const Scene* scene_;
  std::vector<Anchor> points_;
  std::vector<RowCell> row_cells_;
  std::string text_;
  Slot time_, places_, velocities_, forces_, strains_;
  std::vector<double> values_;  ///< of one array, after its length in bytes
};

}  // namespace feder::experiments
