#include "models/scene_file/functions.h"

#include <cmath>
#include <utility>

namespace feder {
namespace {

std::optional<Curve> curve_of(const FunctionText& text, const std::string& where, Diagnostics& problems) {
  std::vector<double> x, y;
  for (const auto& [abscissa, value] : text.pairs) x.push_back(abscissa), y.push_back(value);
  try {
    return Curve(where, x, y);
  } catch (const InputError& error) {
    problems.add(text.place, error.what());
    return std::nullopt;
  }
}

}  // namespace

std::optional<Expression> expression_of(const FunctionText& text, const std::vector<std::string>& variables,
                                        const std::string& where, Diagnostics& problems) {
  try {
    std::string written = text.expression;
    if (text.kind == FunctionText::Kind::kNumber)
      written.append("(").append(to_text(text.number)).append(")");
    return Expression(written, variables);
  } catch (const ExpressionError& error) {
    problems.add({text.place.line, text.place.column + (text.place.line > 0 ? error.column() : 0)},
                 where + ": " + error.what());
    return std::nullopt;
  }
}

std::optional<Target> target_of(const FunctionText& text, const std::string& where, Diagnostics& problems) {
  if (text.kind == FunctionText::Kind::kTable) {
    const auto curve = curve_of(text, where, problems);
    return curve ? std::optional(target_from(*curve)) : std::nullopt;
  }
  const auto expression = expression_of(text, {"t"}, where, problems);
  if (!expression) return std::nullopt;
  Target target = target_from(*expression);
  for (const auto& [what, at_start] : {std::pair("", target.value(0.0)), {", its rate", target.rate(0.0)}})
    if (!std::isfinite(at_start)) {
      problems.add(text.place, where + " = " + quoted(text.expression) + what + " is " +
                                   (std::isnan(at_start) ? "nan" : to_text(at_start)) +
                                   " at t = 0, expected a finite number");
      return std::nullopt;
    }
  return target;
}

std::optional<SpringLaw> law_of(const FunctionText& text, double rest, const std::string& where,
                                Diagnostics& problems) {
  if (text.kind == FunctionText::Kind::kTable) {
    const auto curve = curve_of(text, where, problems);
    return curve ? std::optional(law_from(*curve, rest)) : std::nullopt;
  }
  const auto expression = expression_of(text, {"length", "rate"}, where, problems);
  return expression ? std::optional(law_from(*expression, rest)) : std::nullopt;
}

}  // namespace feder
