#include "engine/check.h"

#include <cmath>
#include <sstream>

namespace feder {

void fail_check(const char* condition, const char* file, int line, const char* message) {
  std::ostringstream out;
  out << file << ':' << line << ": " << message << " (" << condition << " is false)";
  throw MisuseError(out.str());
}

void fail_input(const std::string& place, const std::string& name, double value, const std::string& unit,
                const std::string& expectation) {
  std::ostringstream out;
  out.precision(17);
  out << place << ": " << name << " = " << value << (unit.empty() ? "" : " ") << unit << ", expected "
      << expectation;
  throw InputError(out.str());
}

void require_finite(const std::string& place, const std::string& name, double value,
                    const std::string& unit) {
  if (!std::isfinite(value)) fail_input(place, name, value, unit, "a finite number");
}

void require_positive(const std::string& place, const std::string& name, double value,
                      const std::string& unit) {
  if (!(std::isfinite(value) && value > 0.0)) fail_input(place, name, value, unit, "a finite number > 0");
}

void require_non_negative(const std::string& place, const std::string& name, double value,
                          const std::string& unit) {
  if (!(std::isfinite(value) && value >= 0.0)) fail_input(place, name, value, unit, "a finite number >= 0");
}

}  // namespace feder
