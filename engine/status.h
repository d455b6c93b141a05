#pragma once

#include <string>
#include <utility>

namespace feder {

/// How a step, a solve or a run ended. Numerical failure is a result: it is recorded, never repaired
/// silently.
enum class StatusCode {
  kOk,
  kDiverged,      ///< energy or state left every sensible bound
  kNonFinite,     ///< a NaN or an infinity appeared
  kSingular,      ///< the step matrix has no inverse to working precision
  kInconsistent,  ///< rows contradict each other
  kNotConverged,  ///< Newton, line search or refinement missed its bound
  kStepTooSmall,  ///< step-size control asked for a step below its minimum
  kLimitReached,  ///< a step, time or memory budget ran out
  kRefused,       ///< this method does not admit this scene; the reason names the row or switch
  kInterrupted,
  kIoError,
  kOutOfMemory
};

/// The word written into tables and manifests: "ok", "diverged", "non_finite", ...
const char* to_string(StatusCode code);

/// Exit code of a program that ends with this status: 0, 3 (numerical), 4 (input/output), 5 (memory, limit),
/// 130.
int exit_code(StatusCode code);

struct [[nodiscard]] Status {
  StatusCode code = StatusCode::kOk;
  std::string reason;  ///< empty when ok, otherwise one sentence with the place and the value

  bool ok() const { return code == StatusCode::kOk; }
  static Status failure(StatusCode code, std::string reason) { return {code, std::move(reason)}; }
};

}  // namespace feder
