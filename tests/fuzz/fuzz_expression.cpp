// Any text is an ExpressionError or an expression whose value and derivatives can be had anywhere.
#include <cstdint>
#include <string>

#include "models/scene_file/expression.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace feder;
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    const Expression expression(text, {"t", "x"});
    for (const double t : {0.0, -1.5, 1e300}) {
      const double at[] = {t, 0.5}, direction[] = {1.0, -2.0};
      const double value = expression.value(at), again = expression.along(at, direction).value;
      if (!(value == again || (value != value && again != again))) __builtin_trap();
    }
  } catch (const ExpressionError& error) {
    if (error.column() < 1 || error.column() > Expression::kLongestText + 1) __builtin_trap();
  }
  return 0;
}
