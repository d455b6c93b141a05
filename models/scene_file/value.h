#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace feder {

/// Where something stands in a scene file, both from 1. Line 0: in the `column`-th --set of the command line.
struct TextPlace {
  int line = 1, column = 1;
};

/// A value of a scene file with its place. Only the member that `type` names is in use.
struct Value {
  enum class Type { kBoolean, kInteger, kNumber, kText, kArray, kTable, kDate };
  struct Member;

  Type type = Type::kTable;
  TextPlace place = {};
  bool boolean = false;
  std::int64_t integer = 0;
  double number = 0.0;  ///< of integers, too
  std::string text = {};
  std::vector<Value> items = {};
  std::vector<Member> members;  ///< in file order

  const Value* find(std::string_view key) const;
  Value* find(std::string_view key);
  /// As a message shows it, at most 60 characters.
  std::string shown() const;
  const char* type_name() const;
};
struct Value::Member {
  std::string key;
  TextPlace place;
  Value value;
};

class Diagnostics;

/// Limits looked at before the parser sees a byte (it overflows its stack on long dotted keys). Values are
/// counted with the brackets and dots around them: all of them cost memory, up to 350 bytes each.
inline constexpr std::size_t kMostBytes = std::size_t{64} << 20, kLongestLine = std::size_t{1} << 20;
inline constexpr int kMostDots = 32, kDeepestNesting = 64, kMostValues = 1'000'000;

/// Reads TOML text into a table. Every problem goes to `problems`; the table is then not to be used.
Value parse_toml(std::string_view text, Diagnostics& problems);

/// Changes or adds one value: `path` is "end_time", "method.dt", "spring.rope.stiffness" (an entry by its
/// name) or "particle.0.mass" (by its number); `text` is a TOML value, a word without quotes is a text.
/// Problems are reported at the `index`-th --set. At most kMostDots dots in the path.
void set_value(Value& root, const std::string& path, const std::string& text, int index,
               Diagnostics& problems);

}  // namespace feder
