#pragma once

#include <new>
#include <string>

#include "engine/check.h"
#include "engine/status.h"
#include "experiments/support/files.h"

namespace feder::experiments {

/// How a program ends: exit code with the words that go with it.
struct Ending {
  int code = 0;
  std::string status = "ok";  ///< to_string(StatusCode), "bad_input" or "internal_error"
  std::string reason = {};
};

Ending ending_of(const Status& status);

/// The one place where exceptions become exit codes. `action` returns an Ending.
template <typename Action>
Ending guarded(Action&& action) {
  try {
    return action();
  } catch (const InputError& error) {
    return {2, "bad_input", error.what()};
  } catch (const IoError& error) {
    return ending_of(Status::failure(StatusCode::kIoError, error.what()));
  } catch (const std::bad_alloc&) {
    return ending_of(Status::failure(StatusCode::kOutOfMemory, "out of memory"));
  } catch (const std::exception& error) {
    return {1, "internal_error", error.what()};
  }
}

/// "C" locale, round to nearest, signals watched.
void fix_environment();

/// Says on stderr "<program>: <status>: <reason>" unless all went well; returns the exit code.
int report(const std::string& program, const Ending& ending);

}  // namespace feder::experiments
