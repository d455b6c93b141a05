#include "models/parameters.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>

#include "engine/check.h"

namespace feder {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

[[noreturn]] void fail_text(const std::string& place, const std::string& name, const std::string& text,
                            const std::string& expectation) {
  throw InputError(place + ": " + name + " = " + quoted(text) + ", expected " + expectation);
}

// The whole text as one number, independent of the locale.
bool read_number(const std::string& text, double& value) {
  if (text == "inf" || text == "rigid") {
    value = kInfinity;
    return true;
  }
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end;
}

bool read_integer(const std::string& text, int& value) {
  double number = 0.0;
  if (!read_number(text, number) || number != std::trunc(number) || std::abs(number) > 1e9) return false;
  value = static_cast<int>(number);
  return true;
}

}  // namespace

const Range kAnyNumber{-kInfinity, kInfinity, true};
const Range kPositive{0.0, kInfinity, true};
const Range kNonNegative{0.0, kInfinity};
const Range kPositiveOrRigid{0.0, kInfinity, true, true};

Range count_from(int least) {
  return {static_cast<double>(least), kMaxNodes, false, false, true};
}

bool Range::contains(double value) const {
  if (value == kInfinity) return rigid;
  if (!std::isfinite(value) || (integer && value != std::trunc(value))) return false;
  return open ? value > least && value < greatest : value >= least && value <= greatest;
}

std::string Range::expectation() const {
  std::string text = integer ? "an integer" : "a finite number";
  if (least > -kInfinity) text += (open ? " > " : " >= ") + to_text(least);
  if (greatest < kInfinity) text += (open ? " and < " : " and <= ") + to_text(greatest);
  return text + (rigid ? ", or inf (rigid)" : "");
}

void require_count(const std::string& place, const std::string& name, double count, double greatest) {
  if (!(count <= greatest)) fail_input(place, name, count, "", "at most " + to_text(greatest));
}

void require_in(const std::string& place, const std::string& name, double value, const std::string& unit,
                const Range& range) {
  if (!range.contains(value)) fail_input(place, name, value, unit, range.expectation());
}

double parse_number(const std::string& place, const std::string& name, const std::string& text,
                    const Range& range) {
  double value = 0.0;
  if (!read_number(text, value)) fail_text(place, name, text, range.expectation());
  return value;
}

int parse_count(const std::string& place, const std::string& name, const std::string& text,
                const Range& range) {
  int value = 0;
  if (!read_integer(text, value)) fail_text(place, name, text, range.expectation());
  return value;
}

std::vector<Mode> parse_modes(const std::string& place, const std::string& name, const std::string& text) {
  std::vector<Mode> modes;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find('/', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    const std::size_t colon = part.find(':');
    Mode mode;
    if (colon == std::string::npos || !read_integer(part.substr(0, colon), mode.number) ||
        !read_number(part.substr(colon + 1), mode.amplitude))
      fail_text(place, name, part, "mode:amplitude, for example 1:1e-3/-1:1e-5");
    modes.push_back(mode);
    begin = end + 1;
  }
  return modes;
}

int parse_choice(const std::string& place, const std::string& name, const std::string& text,
                 const std::vector<std::string>& choices) {
  const auto found = std::find(choices.begin(), choices.end(), text);
  if (found == choices.end()) fail_text(place, name, text, "one of " + join(choices));
  return static_cast<int>(found - choices.begin());
}

std::string to_text(double value) {
  char buffer[32];
  return std::string(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
}

std::string to_text(const std::vector<Mode>& modes) {
  std::vector<std::string> parts;
  for (const Mode& mode : modes) parts.push_back(std::to_string(mode.number) + ":" + to_text(mode.amplitude));
  return join(parts, "/");
}

std::string quoted(const std::string& text) {
  constexpr std::size_t kLongest = 60;
  std::string shown = text.substr(0, kLongest);
  for (char& c : shown)
    if (c < ' ' || c > '~') c = '?';
  return "'" + shown + (text.size() > kLongest ? "...'" : "'");
}

std::string join(const std::vector<std::string>& words, const char* separator) {
  std::string text;
  for (const std::string& word : words) {
    if (!text.empty()) text += separator;
    text += word;
  }
  return text;
}

std::string nearest(const std::string& text, const std::vector<std::string>& words) {
  std::string best;
  std::size_t least = std::string::npos;
  for (const std::string& word : words) {
    // Levenshtein distance, one row of the table at a time
    std::vector<std::size_t> row(word.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < std::min<std::size_t>(text.size(), 100); ++i) {
      std::size_t diagonal = row[0]++;
      for (std::size_t j = 0; j < word.size(); ++j) {
        const std::size_t change = diagonal + (text[i] != word[j]);
        diagonal = row[j + 1];
        row[j + 1] = std::min({change, row[j] + 1, row[j + 1] + 1});
      }
    }
    if (row.back() < least) least = row.back(), best = word;
  }
  return best;
}

void fail_unknown_parameter(const std::string& place, const std::string& key,
                            const std::vector<Parameter>& parameters) {
  std::vector<std::string> names;
  for (const Parameter& parameter : parameters) names.push_back(parameter.name);
  throw InputError(place + ": no parameter " + quoted(key) + ", did you mean '" + nearest(key, names) +
                   "'? It has: " + join(names));
}

}  // namespace feder
