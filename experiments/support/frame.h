#pragma once

#include <cstdint>

#include "engine/state.h"

namespace feder::experiments {

/// What every writer of frames is given. A writer has name(), the file's start(frames) (of equal length for
/// every number of frames), add(frame, text) and end(); FrameFiles does the rest.
struct Frame {
  std::int64_t index;
  const State& state;
  const History& history;
  const VectorXd& phi;  ///< per row; empty unless a writer needs it
};

}  // namespace feder::experiments
