#pragma once

#include <stdexcept>
#include <string>

namespace feder {

/// Bad input: found before the first step. The message names the place, the value with its unit, and what was
/// expected. Programs turn it into exit code 2.
class InputError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// Misuse of the library by its caller (a broken precondition). Stays on in every build type; exit code 1.
class MisuseError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

[[noreturn]] void fail_check(const char* condition, const char* file, int line, const char* message);

/// Input checks with one wording: "<place>: <name> = <value> <unit>, expected <expectation>".
[[noreturn]] void fail_input(const std::string& place, const std::string& name, double value,
                             const std::string& unit, const std::string& expectation);
void require_finite(const std::string& place, const std::string& name, double value, const std::string& unit);
void require_positive(const std::string& place, const std::string& name, double value,
                      const std::string& unit);
/// Finite and >= 0.
void require_non_negative(const std::string& place, const std::string& name, double value,
                          const std::string& unit);

}  // namespace feder

#define FEDER_CHECK(condition, message) \
  ((condition) ? static_cast<void>(0) : ::feder::fail_check(#condition, __FILE__, __LINE__, message))
