#pragma once

#include <string>

#include "tests/support/random.h"

namespace feder {

/// A random text of the grammar in models/scene_file/expression.h over x, y and t.
class RandomExpression {
 public:
  explicit RandomExpression(std::uint64_t seed) : random_(seed) {}

  std::string text(int depth) {
    return pick({depth > 0 && random_.below(8) == 0 ? choice(depth) : either(depth)});
  }
  /// Smooth everywhere, of moderate size, no powers.
  std::string smooth(int depth) {
    if (depth == 0) return random_.below(3) == 0 ? number() : variable();
    switch (random_.below(6)) {
      case 0:
        return "(" + smooth(depth - 1) + " + " + smooth(depth - 1) + ")";
      case 1:
        return "(" + smooth(depth - 1) + " - " + smooth(depth - 1) + ")";
      case 2:
        return smooth(depth - 1) + "*" + smooth(depth - 1);
      case 3:
        return smooth(depth - 1) + "/(2 + cos(" + smooth(depth - 1) + "))";
      case 4:
        return "sqrt(1 + (" + smooth(depth - 1) + ")^2)";
      default:
        return pick({"sin", "cos", "atan", "tanh"}) + "(" + smooth(depth - 1) + ")";
    }
  }

 private:
  using Words = std::initializer_list<const char*>;
  std::string pick(const std::vector<std::string>& words) {
    return words[static_cast<std::size_t>(random_.below(static_cast<int>(words.size())))];
  }
  std::string space() { return random_.below(3) == 0 ? " " : ""; }
  std::string between(const std::string& a, const std::string& op, const std::string& b) {
    return a + space() + op + space() + b;
  }

  std::string choice(int depth) {
    return either(depth - 1) + " ? " + text(depth - 1) + " : " + text(depth - 1);
  }
  std::string either(int depth) {
    if (depth == 0 || random_.below(10) > 0) return comparison(depth);
    return between(comparison(depth - 1), pick({"&&", "||"}), either(depth - 1));
  }
  std::string comparison(int depth) {
    if (depth == 0 || random_.below(8) > 0) return sum(depth);
    return between(sum(depth - 1), pick({"<", "<=", ">", ">=", "==", "!="}), sum(depth - 1));
  }
  std::string sum(int depth) {
    std::string out = product(depth);
    for (int more = random_.below(3); depth > 0 && more > 0; --more)
      out = between(out, pick({"+", "-"}), product(depth - 1));
    return out;
  }
  std::string product(int depth) {
    std::string out = with_sign(depth);
    for (int more = random_.below(3); depth > 0 && more > 0; --more)
      out = between(out, pick({"*", "/"}), with_sign(depth - 1));
    return out;
  }
  std::string with_sign(int depth) {
    const std::string sign = random_.below(5) == 0 ? pick({"-", "+"}) + space() : "";
    if (depth == 0 || random_.below(5) > 0) return sign + primary(depth);
    return sign + between(primary(depth - 1), "^", with_sign(depth - 1));
  }
  std::string primary(int depth) {
    if (depth == 0 || random_.below(4) == 0) return random_.below(2) == 0 ? number() : variable();
    if (random_.below(2) == 0) return "(" + space() + text(depth - 1) + space() + ")";
    if (random_.below(4) == 0) return pick({"min", "max"}) + arguments(2 + random_.below(3), depth);
    if (random_.below(8) == 0) return "atan2" + arguments(2, depth);
    return pick({"sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "ln", "log10",
                 "sqrt", "abs", "sign"}) +
           arguments(1, depth);
  }
  std::string arguments(int count, int depth) {
    std::string out = "(" + text(depth - 1);
    for (int i = 1; i < count; ++i) out += "," + space() + text(depth - 1);
    return out + ")";
  }
  std::string number() {
    return pick(
        {"0", "1", "2", "3", "0.5", ".25", "1.", "1.5e0", "2E-1", "12e-1", "3.7", "0.1", "1e2", "pi"});
  }
  std::string variable() { return pick({"x", "y", "t"}); }

  Random random_;
};

}  // namespace feder
