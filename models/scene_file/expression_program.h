#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "models/scene_file/jet.h"

namespace feder {

/// Steps of a compiled expression: operands come from a stack, the result goes back to it.
enum class Op : std::uint8_t {
  kNumber,
  kVariable,
  kNegate,
  kAdd,
  kSubtract,
  kMultiply,
  kDivide,
  kPower,
  kLess,
  kLessEqual,
  kGreater,
  kGreaterEqual,
  kEqual,
  kNotEqual,
  kAnd,
  kOr,
  kBranch,  ///< takes the condition: on 0 to `operand`, on NaN past the whole choice
  kJump,    ///< to `operand`
  kSin,
  kCos,
  kTan,
  kAsin,
  kAcos,
  kAtan,
  kAtan2,
  kSinh,
  kCosh,
  kTanh,
  kExp,
  kLn,
  kLog10,
  kSqrt,
  kAbs,
  kSign,
  kMin,
  kMax
};

struct Instruction {
  Op op = Op::kNumber;
  int operand = 0;      ///< of a variable its index, of a jump the next instruction
  double number = 0.0;  ///< of kNumber
};

/// A function of the language. With more than two arguments (min, max) it is applied pair by pair.
struct FunctionInfo {
  const char* name;
  Op op;
  int least, most;  ///< number of arguments
};
std::span<const FunctionInfo> expression_functions();

/// A compiled expression in postfix order.
struct Program {
  static constexpr int kStack = 64;  ///< places of the stack; the compiler refuses what needs more
  std::vector<Instruction> code;

  double value(std::span<const double> x) const;
  /// f(x + s direction) at s = 0.
  Jet along(std::span<const double> x, std::span<const double> direction) const;
};

}  // namespace feder
