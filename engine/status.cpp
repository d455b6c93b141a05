#include "engine/status.h"

namespace feder {

const char* to_string(StatusCode code) {
  switch (code) {
    case StatusCode::kOk:
      return "ok";
    case StatusCode::kDiverged:
      return "diverged";
    case StatusCode::kNonFinite:
      return "non_finite";
    case StatusCode::kSingular:
      return "singular";
    case StatusCode::kInconsistent:
      return "inconsistent";
    case StatusCode::kNotConverged:
      return "not_converged";
    case StatusCode::kStepTooSmall:
      return "step_too_small";
    case StatusCode::kLimitReached:
      return "limit_reached";
    case StatusCode::kRefused:
      return "refused";
    case StatusCode::kInterrupted:
      return "interrupted";
    case StatusCode::kIoError:
      return "io_error";
    case StatusCode::kOutOfMemory:
      return "out_of_memory";
  }
  return "unknown";
}

int exit_code(StatusCode code) {
  switch (code) {
    case StatusCode::kOk:
      return 0;
    case StatusCode::kInterrupted:
      return 130;
    case StatusCode::kIoError:
      return 4;
    case StatusCode::kOutOfMemory:
    case StatusCode::kLimitReached:
      return 5;
    default:
      return 3;
  }
}

}  // namespace feder
