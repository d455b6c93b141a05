// Scene text to a tree of values. Limits are checked on the bytes first: toml++ 3.3 runs out of stack on a
// key with 100 000 dots.
#include "models/scene_file/value.h"

#include <algorithm>
#include <utility>

#define TOML_EXCEPTIONS 0
#include <toml++/toml.h>

#include "models/parameters.h"
#include "models/scene_file/diagnostics.h"

namespace feder {
namespace {

// Follows strings and comments of a TOML text, byte by byte.
class Scan {
 public:
  Scan(std::string_view text, Diagnostics& problems) : text_(text), problems_(problems) {}

  // False after the first problem.
  bool within_limits() {
    if (text_.size() > kMostBytes)
      return refuse("file of " + std::to_string(text_.size()) + " bytes, expected at most " +
                    std::to_string(kMostBytes));
    while (at_ < text_.size())
      if (!step()) return false;
    return true;
  }

 private:
  bool step() {
    const char c = text_[at_];
    if (c == '\n') {
      ++line_, start_ = ++at_, dots_ = 0;
      return true;
    }
    if (at_ - start_ >= kLongestLine)
      return refuse("line longer than " + std::to_string(kLongestLine) + " bytes");
    if (c == '"' || c == '\'') return skip_text(c);
    if (c == '#') {
      while (at_ < text_.size() && text_[at_] != '\n') ++at_;
      return at_ - start_ < kLongestLine ||
             refuse("line longer than " + std::to_string(kLongestLine) + " bytes");
    }
    if (c == '[' || c == '{') {
      if (++depth_ > kDeepestNesting)
        return refuse("brackets nested deeper than " + std::to_string(kDeepestNesting));
    } else if (c == ']' || c == '}') {
      depth_ = std::max(0, depth_ - 1);
    } else if (c == '=' || c == ',') {
      dots_ = 0;  // a new key or value
      if (++values_ > kMostValues) return refuse("more than " + std::to_string(kMostValues) + " values");
    } else if (c == '.' && ++dots_ > kMostDots) {
      return refuse("more than " + std::to_string(kMostDots) + " dots in a key");
    }
    ++at_;
    return true;
  }

  // The text that starts here, in one or three quotes, may contain anything.
  bool skip_text(char quote) {
    const bool three = text_.substr(at_, 3) == std::string(3, quote);
    at_ += three ? 3 : 1;
    while (at_ < text_.size()) {
      if (text_[at_] == '\n') {
        if (!three) return true;  // the parser's to complain about
        ++line_, start_ = at_ + 1, dots_ = 0;
      }
      if (at_ - start_ >= kLongestLine && text_[at_] != '\n')
        return refuse("line longer than " + std::to_string(kLongestLine) + " bytes");
      if (quote == '"' && text_[at_] == '\\') {
        at_ += text_.substr(at_ + 1, 1) == "\n" ? 1 : 2;
      } else if (text_[at_] == quote && (!three || text_.substr(at_, 3) == std::string(3, quote))) {
        at_ += three ? 3 : 1;
        return true;
      } else {
        ++at_;
      }
    }
    return true;
  }

  bool refuse(const std::string& message) {
    problems_.add({line_, static_cast<int>(at_ - start_) + 1}, message);
    return false;
  }

  std::string_view text_;
  Diagnostics& problems_;
  std::size_t at_ = 0, start_ = 0;
  int line_ = 1, dots_ = 0, depth_ = 0, values_ = 0;
};

TextPlace place_of(const toml::source_region& source) {
  return {std::max(1, static_cast<int>(source.begin.line)),
          std::max(1, static_cast<int>(source.begin.column))};
}

Value converted(const toml::node& node) {
  Value value;
  value.place = place_of(node.source());
  if (const auto* flag = node.as_boolean()) {
    value.type = Value::Type::kBoolean, value.boolean = flag->get();
  } else if (const auto* integer = node.as_integer()) {
    value.type = Value::Type::kInteger, value.integer = integer->get();
    value.number = static_cast<double>(value.integer);
  } else if (const auto* number = node.as_floating_point()) {
    value.type = Value::Type::kNumber, value.number = number->get();
  } else if (const auto* text = node.as_string()) {
    value.type = Value::Type::kText, value.text = text->get();
  } else if (const auto* array = node.as_array()) {
    value.type = Value::Type::kArray;
    value.items.reserve(array->size());
    for (const toml::node& item : *array) value.items.push_back(converted(item));
  } else if (const auto* table = node.as_table()) {
    value.members.reserve(table->size());
    for (const auto& [key, item] : *table)
      value.members.push_back({std::string(key.str()), place_of(key.source()), converted(item)});
    std::stable_sort(value.members.begin(), value.members.end(), [](const auto& x, const auto& y) {
      return std::pair(x.place.line, x.place.column) < std::pair(y.place.line, y.place.column);
    });
  } else {
    value.type = Value::Type::kDate;
  }
  return value;
}

void move_to(Value& value, TextPlace place) {
  value.place = place;
  for (Value& item : value.items) move_to(item, place);
  for (Value::Member& member : value.members) member.place = place, move_to(member.value, place);
}

// One TOML value; a word that is none is a text.
Value value_of(const std::string& text, TextPlace place, Diagnostics& problems) {
  if (Scan(text, problems).within_limits() && text.find('\n') == std::string::npos)
    if (toml::parse_result result = toml::parse("value = " + text); result && result.table().size() == 1) {
      Value value = converted(*result.table().get("value"));
      move_to(value, place);
      return value;
    }
  Value value;
  value.type = Value::Type::kText, value.place = place, value.text = text;
  return value;
}

// The entry of an array of tables by name or number.
Value* entry(Value& array, const std::string& key) {
  for (Value& item : array.items)
    if (const Value* name = item.find("name"); name && name->text == key) return &item;
  const bool digits = !key.empty() && key.size() < 9 &&
                      std::all_of(key.begin(), key.end(), [](char c) { return c >= '0' && c <= '9'; });
  const std::size_t index = digits ? std::stoul(key) : array.items.size();
  return index < array.items.size() ? &array.items[index] : nullptr;
}

}  // namespace

const Value* Value::find(std::string_view key) const {
  for (const Member& member : members)
    if (member.key == key) return &member.value;
  return nullptr;
}

Value* Value::find(std::string_view key) {
  return const_cast<Value*>(std::as_const(*this).find(key));
}

const char* Value::type_name() const {
  switch (type) {
    case Type::kBoolean:
      return "a boolean";
    case Type::kInteger:
      return "an integer";
    case Type::kNumber:
      return "a number";
    case Type::kText:
      return "a text";
    case Type::kArray:
      return "an array";
    case Type::kTable:
      return "a table";
    case Type::kDate:
      return "a date or time";
  }
  return "";
}

std::string Value::shown() const {
  switch (type) {
    case Type::kBoolean:
      return boolean ? "true" : "false";
    case Type::kInteger:
      return std::to_string(integer);
    case Type::kNumber:
      return to_text(number);
    case Type::kText:
      return quoted(text);
    case Type::kArray:
      return "an array of " + std::to_string(items.size());
    default:
      return type_name();
  }
}

Value parse_toml(std::string_view text, Diagnostics& problems) {
  if (!Scan(text, problems).within_limits()) return {};
  toml::parse_result result = toml::parse(text);
  if (!result) {
    std::string what(result.error().description());
    for (char& c : what)
      if (c < ' ' || c > '~') c = '?';
    problems.add(place_of(result.error().source()), what.substr(0, 300));
    return {};
  }
  return converted(result.table());
}

void set_value(Value& root, const std::string& path, const std::string& text, int index,
               Diagnostics& problems) {
  const TextPlace place{0, index};
  Value* at = &root;
  for (std::size_t begin = 0;;) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    const std::string key = path.substr(begin, end - begin);
    if (key.empty()) return problems.add(place, "expected key.key = value with a name between any two dots");
    Value* next = at->type == Value::Type::kArray ? entry(*at, key) : at->find(key);
    if (!next && at->type != Value::Type::kTable)
      return problems.add(place, "the scene has no entry " + quoted(key));
    if (!next) {  // a key the file leaves at its default, or one the reader will not know
      at->members.push_back({key, place, {}});
      next = &at->members.back().value;
      next->place = place;
    }
    if (end == path.size()) {
      *next = value_of(text, place, problems);
      return;
    }
    if (next->type != Value::Type::kTable && next->type != Value::Type::kArray)
      return problems.add(place,
                          quoted(path.substr(0, end)) + " is " + next->type_name() + " and has no keys");
    at = next;
    begin = end + 1;
  }
}

}  // namespace feder
