// One evaluator for numbers and for jets. NaN stays NaN: a comparison, a choice or a minimum of something
// that is no number is none.
#include "models/scene_file/expression_program.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace feder {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double value_of(double x) {
  return x;
}
double value_of(const Jet& x) {
  return x.value;
}
double power(double a, double b) {
  return std::pow(a, b);
}
double atan2(double y, double x) {
  return std::atan2(y, x);
}

/// f(g); `derivatives` gives f' and f'' and is asked only where they are needed.
template <class T, class Derivatives>
T apply(const T& g, double f, const Derivatives& derivatives) {
  if constexpr (std::is_same_v<T, double>) {
    return f;
  } else {
    if (!g.varies) return {f};
    const auto [f1, f2] = derivatives();
    return chain(g, f, f1, f2);
  }
}

using Pair = std::pair<double, double>;

template <class T>
T function(Op op, const T& g) {
  const double x = value_of(g);
  switch (op) {
    case Op::kSin:
      return apply(g, std::sin(x), [x] { return Pair(std::cos(x), -std::sin(x)); });
    case Op::kCos:
      return apply(g, std::cos(x), [x] { return Pair(-std::sin(x), -std::cos(x)); });
    case Op::kTan: {
      const double f = std::tan(x);
      return apply(g, f, [f] { return Pair(1.0 + f * f, 2.0 * f * (1.0 + f * f)); });
    }
    case Op::kAsin:
    case Op::kAcos: {
      const double sign = op == Op::kAsin ? 1.0 : -1.0;
      return apply(g, op == Op::kAsin ? std::asin(x) : std::acos(x), [x, sign] {
        const double square = (1.0 - x) * (1.0 + x), f1 = sign / std::sqrt(square);
        return Pair(f1, f1 * x / square);
      });
    }
    case Op::kAtan:
      return apply(g, std::atan(x), [x] {
        const double f1 = 1.0 / (1.0 + x * x);
        return Pair(f1, -2.0 * x * f1 * f1);
      });
    case Op::kSinh:
      return apply(g, std::sinh(x), [x] { return Pair(std::cosh(x), std::sinh(x)); });
    case Op::kCosh:
      return apply(g, std::cosh(x), [x] { return Pair(std::sinh(x), std::cosh(x)); });
    case Op::kTanh: {
      const double f = std::tanh(x);
      return apply(g, f, [x, f] {
        const double f1 = 1.0 / (std::cosh(x) * std::cosh(x));
        return Pair(f1, -2.0 * f * f1);
      });
    }
    case Op::kExp: {
      const double f = std::exp(x);
      return apply(g, f, [f] { return Pair(f, f); });
    }
    case Op::kLn:
      return apply(g, std::log(x), [x] { return Pair(1.0 / x, -1.0 / (x * x)); });
    case Op::kLog10:
      return apply(g, std::log10(x),
                   [x] { return Pair(1.0 / (x * std::numbers::ln10), -1.0 / (x * x * std::numbers::ln10)); });
    case Op::kSqrt: {
      const double f = std::sqrt(x);
      return apply(g, f, [x, f] { return Pair(0.5 / f, -0.25 / (x * f)); });
    }
    case Op::kAbs: {
      const double sign = x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : 0.0;
      return apply(g, std::abs(x), [sign] { return Pair(sign, 0.0); });
    }
    case Op::kSign:
      return T{std::isnan(x) ? x : x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : 0.0};
    default:
      return -g;
  }
}

double truth(Op op, double a, double b) {
  if (std::isnan(a)) return a;
  if (op == Op::kAnd && a == 0.0) return 0.0;
  if (op == Op::kOr && a != 0.0) return 1.0;
  if (std::isnan(b)) return b;
  switch (op) {
    case Op::kLess:
      return a < b;
    case Op::kLessEqual:
      return a <= b;
    case Op::kGreater:
      return a > b;
    case Op::kGreaterEqual:
      return a >= b;
    case Op::kEqual:
      return a == b;
    case Op::kNotEqual:
      return a != b;
    default:
      return b != 0.0;
  }
}

template <class T>
T combined(Op op, const T& a, const T& b) {
  switch (op) {
    case Op::kAdd:
      return a + b;
    case Op::kSubtract:
      return a - b;
    case Op::kMultiply:
      return a * b;
    case Op::kDivide:
      return a / b;
    case Op::kPower:
      return power(a, b);
    case Op::kAtan2:
      return atan2(a, b);
    case Op::kMin:
      return std::isnan(value_of(a)) ? a : value_of(a) <= value_of(b) ? a : b;
    case Op::kMax:
      return std::isnan(value_of(a)) ? a : value_of(a) >= value_of(b) ? a : b;
    default:
      return T{truth(op, value_of(a), value_of(b))};
  }
}

template <class T, class Variable>
T run(const std::vector<Instruction>& code, const Variable& variable) {
  std::array<T, Program::kStack> stack;
  std::size_t top = 0;  // places in use
  for (std::size_t at = 0; at < code.size();) {
    const Instruction& step = code[at++];
    switch (step.op) {
      case Op::kNumber:
        stack[top++] = T{step.number};
        break;
      case Op::kVariable:
        stack[top++] = variable(static_cast<std::size_t>(step.operand));
        break;
      case Op::kJump:
        at = static_cast<std::size_t>(step.operand);
        break;
      case Op::kBranch: {
        const double condition = value_of(stack[--top]);
        if (condition == 0.0 || std::isnan(condition)) at = static_cast<std::size_t>(step.operand);
        if (std::isnan(condition)) {
          stack[top++] = T{condition};
          at = static_cast<std::size_t>(code[at - 1].operand);  // the jump that ends the first branch
        }
        break;
      }
      case Op::kAdd:
      case Op::kSubtract:
      case Op::kMultiply:
      case Op::kDivide:
      case Op::kPower:
      case Op::kLess:
      case Op::kLessEqual:
      case Op::kGreater:
      case Op::kGreaterEqual:
      case Op::kEqual:
      case Op::kNotEqual:
      case Op::kAnd:
      case Op::kOr:
      case Op::kAtan2:
      case Op::kMin:
      case Op::kMax:
        --top;
        stack[top - 1] = combined(step.op, stack[top - 1], stack[top]);
        break;
      default:
        stack[top - 1] = function(step.op, stack[top - 1]);
    }
  }
  return stack[0];
}

constexpr int kAny = 1000;
constexpr FunctionInfo kFunctions[] = {
    {"sin", Op::kSin, 1, 1},     {"cos", Op::kCos, 1, 1},    {"tan", Op::kTan, 1, 1},
    {"asin", Op::kAsin, 1, 1},   {"acos", Op::kAcos, 1, 1},  {"atan", Op::kAtan, 1, 1},
    {"atan2", Op::kAtan2, 2, 2}, {"sinh", Op::kSinh, 1, 1},  {"cosh", Op::kCosh, 1, 1},
    {"tanh", Op::kTanh, 1, 1},   {"exp", Op::kExp, 1, 1},    {"ln", Op::kLn, 1, 1},
    {"log10", Op::kLog10, 1, 1}, {"sqrt", Op::kSqrt, 1, 1},  {"abs", Op::kAbs, 1, 1},
    {"sign", Op::kSign, 1, 1},   {"min", Op::kMin, 2, kAny}, {"max", Op::kMax, 2, kAny}};

}  // namespace

std::span<const FunctionInfo> expression_functions() {
  return kFunctions;
}

double Program::value(std::span<const double> x) const {
  return run<double>(code, [x](std::size_t i) { return x[i]; });
}

Jet Program::along(std::span<const double> x, std::span<const double> direction) const {
  const Jet at = run<Jet>(code, [x, direction](std::size_t i) {
    return Jet{x[i], direction[i], 0.0, direction[i] != 0.0};
  });
  return std::isnan(at.value) ? Jet{kNaN, kNaN, kNaN, at.varies} : at;
}

}  // namespace feder
