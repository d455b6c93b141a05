#pragma once

#include "engine/state.h"

namespace feder {

/// All x with normal . x = offset. As a half space: all x with normal . x <= offset.
struct Plane {
  Vector3d normal = Vector3d::UnitZ();  ///< not 0; need not be unit
  double offset = 0.0;                  ///< [m] for a unit normal
};

}  // namespace feder
