#pragma once

#include "models/scene_file/scene.h"

namespace feder {

/// A model without names of its own as a scene: "node 12" (particles and world points), "body 0", rows named
/// by System::row_name in the order of their public ids. Dials are no places and have no entry.
Scene scene_of(Model model);

}  // namespace feder
