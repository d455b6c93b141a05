#include "models/scene_file/expression.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <string_view>

#include "models/parameters.h"
#include "models/scene_file/expression_program.h"

namespace feder {
namespace {

constexpr const char* kOperand = "a number, a variable, a function or '('";

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}
bool is_name(std::string_view text) {
  return !text.empty() && is_letter(text[0]) &&
         std::all_of(text.begin(), text.end(), [](char c) { return is_letter(c) || is_digit(c); });
}

std::vector<std::string> function_names() {
  std::vector<std::string> names;
  for (const FunctionInfo& f : expression_functions()) names.emplace_back(f.name);
  return names;
}

/// Recursive descent; the grammar is in the header.
class Compiler {
 public:
  Compiler(const std::string& text, const std::vector<std::string>& variables)
      : text_(text), variables_(variables) {
    if (text.size() > Expression::kLongestText)
      throw ExpressionError("expression of " + std::to_string(text.size()) +
                                " characters, expected at most " + std::to_string(Expression::kLongestText),
                            Expression::kLongestText + 1);
    advance();
  }

  Program compile() {
    expression();
    if (!token_.empty())
      fail(operand_follows() ? "an operator before it"
           : token_ == "="   ? "an operator (equality is '==')"
                             : "an operator or the end");
    return std::move(program_);
  }

 private:
  [[noreturn]] void fail(const std::string& expected) const {
    const std::string found = token_.empty()            ? "the end"
                              : (token_[0] & 0x80) != 0 ? "a character that is not ASCII"
                                                        : quoted(std::string(token_));
    fail_at(column_, "found " + found + ", expected " + expected);
  }
  [[noreturn]] void fail_at(std::size_t column, const std::string& what) const {
    throw ExpressionError("expression " + quoted(text_) + ", column " + std::to_string(column) + ": " + what,
                          static_cast<int>(column));
  }

  bool operand_follows() const {
    return is_letter(token_[0]) || is_digit(token_[0]) || token_[0] == '.' || token_[0] == '(';
  }

  /// Next token: a number, a name, an operator; empty at the end.
  void advance() {
    while (next_ < text_.size() && std::string_view(" \t\r\n").find(text_[next_]) != std::string_view::npos)
      ++next_;
    column_ = next_ + 1;
    const std::string_view rest = std::string_view(text_).substr(next_);
    token_ = rest.substr(0, length(rest));
    next_ += token_.size();
  }

  std::size_t length(std::string_view rest) {
    if (rest.empty()) return 0;
    if (is_letter(rest[0]))
      return static_cast<std::size_t>(
          std::find_if_not(rest.begin(), rest.end(), [](char c) { return is_letter(c) || is_digit(c); }) -
          rest.begin());
    if (is_digit(rest[0]) || rest[0] == '.') {
      const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), number_);
      if (error == std::errc::result_out_of_range)
        fail_at(column_, "found " + quoted(std::string(rest.data(), end)) +
                             ", expected a number that is 0 or between 1e-307 and 1e308");
      return error == std::errc() ? static_cast<std::size_t>(end - rest.data()) : 1;
    }
    for (const char* two : {"<=", ">=", "==", "!=", "&&", "||"})
      if (rest.starts_with(two)) return 2;
    return 1;
  }

  bool take(std::string_view token) {
    if (token_ != token) return false;
    advance();
    return true;
  }
  void require(std::string_view token, const std::string& expected) {
    if (!take(token)) fail(expected);
  }

  /// Appends an instruction that leaves the stack `change` places higher.
  std::size_t emit(Op op, int change, int operand = 0, double number = 0.0) {
    depth_ += change;
    if (depth_ > Program::kStack)
      fail_at(column_, "too many operands wait for their operators, expected at most " +
                           std::to_string(Program::kStack));
    program_.code.push_back({op, operand, number});
    return program_.code.size() - 1;
  }

  /// Left-associative chain of two-operand operators.
  template <class Part>
  void sequence(std::initializer_list<std::pair<const char*, Op>> operators, const Part& part) {
    part();
    for (bool more = true; more;) {
      more = false;
      for (const auto& [token, op] : operators)
        if (take(token)) {
          part();
          emit(op, -1);
          more = true;
          break;
        }
    }
  }

  void expression() {
    const Nesting nesting(*this);
    either();
    if (!take("?")) return;
    const std::size_t branch = emit(Op::kBranch, -1);
    expression();
    require(":", "':' and what holds otherwise");
    const std::size_t jump = emit(Op::kJump, -1);
    program_.code[branch].operand = static_cast<int>(program_.code.size());
    expression();
    program_.code[jump].operand = static_cast<int>(program_.code.size());
  }

  void either() {
    sequence({{"||", Op::kOr}}, [this] { sequence({{"&&", Op::kAnd}}, [this] { comparison(); }); });
  }

  void comparison() {
    static constexpr std::pair<const char*, Op> kComparisons[] = {
        {"<", Op::kLess},          {"<=", Op::kLessEqual}, {">", Op::kGreater},
        {">=", Op::kGreaterEqual}, {"==", Op::kEqual},     {"!=", Op::kNotEqual}};
    const auto next = [this] {
      return std::find_if(std::begin(kComparisons), std::end(kComparisons),
                          [this](const auto& c) { return token_ == c.first; });
    };
    sum();
    const auto found = next();
    if (found == std::end(kComparisons)) return;
    advance();
    sum();
    emit(found->second, -1);
    if (next() != std::end(kComparisons)) fail("no second comparison (write a < b && b < c)");
  }

  void sum() {
    sequence({{"+", Op::kAdd}, {"-", Op::kSubtract}}, [this] {
      sequence({{"*", Op::kMultiply}, {"/", Op::kDivide}}, [this] { with_sign(); });
    });
  }

  void with_sign() {
    const Nesting nesting(*this);
    const bool negative = token_ == "-";
    if (negative || token_ == "+") advance();
    primary();
    if (take("^")) {
      with_sign();
      emit(Op::kPower, -1);
    }
    if (negative) emit(Op::kNegate, 0);
  }

  void primary() {
    if (token_.empty()) fail(kOperand);
    if (is_letter(token_[0])) return name();
    if (take("(")) {
      expression();
      return require(")", "')' or an operator");
    }
    if (!operand_follows() || token_ == ".") fail(kOperand);
    emit(Op::kNumber, 1, 0, number_);
    advance();
  }

  void name() {
    const std::string word(token_);
    const std::size_t column = column_;
    advance();
    const auto variable = std::find(variables_.begin(), variables_.end(), word);
    if (variable != variables_.end()) {
      emit(Op::kVariable, 1, static_cast<int>(variable - variables_.begin()));
    } else if (word == "pi") {
      emit(Op::kNumber, 1, 0, std::numbers::pi);
    } else {
      const auto functions = expression_functions();
      const auto found =
          std::find_if(functions.begin(), functions.end(), [&](const auto& f) { return word == f.name; });
      if (found == functions.end()) fail_unknown(word, column);
      call(*found, column);
    }
  }

  [[noreturn]] void fail_unknown(const std::string& word, std::size_t column) const {
    std::vector<std::string> names = variables_;
    names.emplace_back("pi");
    if (token_ == "(") names = function_names();
    fail_at(column, "found " + quoted(word) + ", expected a variable (" + join(variables_) +
                        "), pi or a function (" + join(function_names(), " ") + "); did you mean '" +
                        nearest(word, names) + "'?");
  }

  void call(const FunctionInfo& function, std::size_t column) {
    require("(", std::string("'(' after the function ") + function.name);
    int arguments = 0;
    do {
      expression();
      if (++arguments >= 2 && function.most > 2) emit(function.op, -1);
    } while (take(","));
    require(")", "')', ',' or an operator");
    if (arguments < function.least || arguments > function.most)
      fail_at(column, "found " + std::to_string(arguments) + " arguments of " + function.name +
                          ", expected " + (function.most > 2 ? "at least " : "") +
                          std::to_string(function.least));
    if (function.most <= 2) emit(function.op, 1 - arguments);
  }

  /// Guards the recursion: a pair of parentheses passes through it twice.
  struct Nesting {
    explicit Nesting(Compiler& compiler) : owner(compiler) {
      if (++owner.nesting_ > 2 * Expression::kDeepestNesting)
        owner.fail_at(owner.column_, "nested deeper than the " + std::to_string(Expression::kDeepestNesting) +
                                         " levels allowed");
    }
    ~Nesting() { --owner.nesting_; }
    Nesting(const Nesting&) = delete;
    Nesting& operator=(const Nesting&) = delete;
    Compiler& owner;
  };

  const std::string& text_;
  const std::vector<std::string>& variables_;
  std::string_view token_;
  double number_ = 0.0;
  std::size_t next_ = 0, column_ = 1;
  int depth_ = 0, nesting_ = 0;
  Program program_;
};

void check_variables(const std::vector<std::string>& variables) {
  const std::vector<std::string> functions = function_names();
  for (auto name = variables.begin(); name != variables.end(); ++name) {
    const std::string where = "variable " + quoted(*name) + ": ";
    if (!is_name(*name)) throw InputError(where + "expected letters, digits and '_', a letter first");
    if (*name == "pi" || std::find(functions.begin(), functions.end(), *name) != functions.end())
      throw InputError(where + "expected a name that expressions do not know already");
    if (std::find(variables.begin(), name, *name) != name) throw InputError(where + "named twice");
  }
}

}  // namespace

Expression::Expression(const std::string& text, const std::vector<std::string>& variables)
    : text_(text), variables_(variables) {
  check_variables(variables_);
  program_ = std::make_shared<const Program>(Compiler(text_, variables_).compile());
}

void Expression::check(std::size_t values) const {
  FEDER_CHECK(program_, "an expression without text");
  FEDER_CHECK(values == variables_.size(), "one value per variable");
}

double Expression::value(std::span<const double> x) const {
  check(x.size());
  return program_->value(x);
}

Jet Expression::along(std::span<const double> x, std::span<const double> direction) const {
  check(x.size());
  check(direction.size());
  return program_->along(x, direction);
}

bool Expression::uses(const std::string& variable) const {
  const auto at = std::find(variables_.begin(), variables_.end(), variable);
  return program_ && at != variables_.end() &&
         std::any_of(program_->code.begin(), program_->code.end(), [&](const Instruction& step) {
           return step.op == Op::kVariable && step.operand == at - variables_.begin();
         });
}

}  // namespace feder
