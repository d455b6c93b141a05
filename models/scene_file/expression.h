// Small mathematical expressions in named variables.
//   expression := or ['?' expression ':' expression]          only the branch taken is evaluated
//   or := and {'||' and}     and := comparison {'&&' comparison}     comparison := sum [('<' | '<=' | '>' |
//   '>=' | '==' | '!=') sum]     sum := product {('+' | '-') product}     product := signed {('*' | '/')
//   signed} signed := ['+' | '-'] power     power := primary ['^' signed]          so -2^2 = -4, 2^-1 = 0.5,
//   2^3^2 = 512 primary := number | variable | 'pi' | function '(' expression {',' expression} ')' | '('
//   expression ')'
// Functions: sin cos tan asin acos atan atan2 sinh cosh tanh exp ln log10 sqrt abs sign, min and max of two
// or more. Steps and kinks: a comparison and sign have derivative 0, abs(0) too; min and max take the
// derivatives of the first of equal arguments. What is NaN stays NaN, also through a comparison or as a
// condition.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/check.h"
#include "models/scene_file/jet.h"

namespace feder {

struct Program;

/// The text is no expression: names the place, what was found, what was expected and the nearest known name.
class ExpressionError : public InputError {
 public:
  ExpressionError(const std::string& message, int column) : InputError(message), column_(column) {}
  int column() const { return column_; }  ///< in the text, from 1

 private:
  int column_;
};

/// A compiled expression. Evaluation allocates nothing and is safe from several threads; copies share the
/// code.
class Expression {
 public:
  static constexpr int kLongestText = 4096, kDeepestNesting = 64;

  /// Nothing: every use is misuse.
  Expression() = default;
  /// `variables`: letters, digits and '_', no two the same, none a function or "pi" (InputError). Throws
  /// ExpressionError.
  Expression(const std::string& text, const std::vector<std::string>& variables);

  /// One value per variable, in their order. A value outside a function's domain gives NaN or infinity.
  double value(std::span<const double> x) const;
  /// Value, first and second derivative of f(x + s direction) at s = 0.
  Jet along(std::span<const double> x, std::span<const double> direction) const;

  const std::string& text() const { return text_; }
  const std::vector<std::string>& variables() const { return variables_; }
  /// Does the text contain this variable?
  bool uses(const std::string& variable) const;

 private:
  void check(std::size_t values) const;

  std::string text_;
  std::vector<std::string> variables_;
  std::shared_ptr<const Program> program_;
};

}  // namespace feder
