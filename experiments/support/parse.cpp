#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "engine/check.h"
#include "experiments/support/settings.h"

namespace feder::experiments {
namespace {

constexpr std::int64_t kLargestGrid = 100000;
constexpr std::string_view kOpening = "([{";
constexpr std::string_view kClosing = ")]}";

[[noreturn]] void fail(const std::string& place, std::string_view text, const std::string& expected) {
  throw InputError(fmt::format("{}: got '{}', expected {}", place, text, expected));
}

template <typename Number>
std::optional<Number> read_whole(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// Separators inside brackets do not count: "chain,S3b(30,10)" is two words, "[0,0,1],[1,0,0]" too.
std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  std::size_t begin = 0;
  int depth = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (kOpening.find(text[i]) != kOpening.npos) ++depth;
    if (kClosing.find(text[i]) != kClosing.npos) --depth;
    if (text[i] != separator || depth > 0) continue;
    parts.push_back(text.substr(begin, i - begin));
    begin = i + 1;
  }
  parts.push_back(text.substr(begin));
  return parts;
}

/// lo:hi:count with both ends exact and a constant ratio between neighbours; lo:hi:count:lin with a constant
/// difference.
std::vector<double> number_grid(const std::string& place, std::string_view text) {
  const std::vector<std::string_view> parts = split(text, ':');
  const bool linear = parts.size() == 4 && parts[3] == "lin";
  const char* expected =
      "a logarithmic grid lo:hi:count with lo > 0, hi > 0 and 2 <= count <= 100000, or a linear one "
      "lo:hi:count:lin";
  if (parts.size() != 3 && !linear) fail(place, text, expected);
  const std::optional<double> lo = read_whole<double>(parts[0]);
  const std::optional<double> hi = read_whole<double>(parts[1]);
  const std::optional<std::int64_t> count = read_whole<std::int64_t>(parts[2]);
  const auto fits = [&](const std::optional<double>& x) {
    return x && std::isfinite(*x) && (linear || *x > 0);
  };
  if (!fits(lo) || !fits(hi) || !count || *count < 2 || *count > kLargestGrid) fail(place, text, expected);
  std::vector<double> grid(static_cast<std::size_t>(*count));
  const long double from = linear ? *lo : std::log10(*lo), to = linear ? *hi : std::log10(*hi);
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const long double at =
        std::lerp(from, to, static_cast<long double>(i) / static_cast<long double>(grid.size() - 1));
    // base 10, powers in extended precision: decades come out exactly
    grid[i] = static_cast<double>(linear ? at : std::pow(10.0L, at));
  }
  grid.front() = *lo;
  grid.back() = *hi;
  return grid;
}

}  // namespace

double parse_number(const std::string& place, std::string_view text) {
  const std::optional<double> value = read_whole<double>(text);
  if (!value || !std::isfinite(*value)) fail(place, text, "a finite number");
  return *value;
}

std::int64_t parse_integer(const std::string& place, std::string_view text) {
  const std::optional<std::int64_t> value = read_whole<std::int64_t>(text);
  if (!value) fail(place, text, "a whole number");
  return *value;
}

std::vector<double> parse_numbers(const std::string& place, std::string_view text) {
  if (text.find(':') != std::string_view::npos) return number_grid(place, text);
  std::vector<double> values;
  for (const std::string_view part : split(text, ',')) {
    const std::optional<double> value = read_whole<double>(part);
    if (!value || !std::isfinite(*value))
      fail(place, text, "finite numbers a,b,c or a grid lo:hi:count or lo:hi:count:lin");
    values.push_back(*value);
  }
  return values;
}

std::vector<std::string> parse_texts(const std::string& place, std::string_view text) {
  std::vector<std::string> words;
  for (const std::string_view part : split(text, ',')) {
    if (part.empty()) fail(place, text, "words separated by single commas");
    words.emplace_back(part);
  }
  return words;
}

std::string nearest(std::string_view word, const std::vector<std::string>& candidates) {
  const auto distance = [word](std::string_view other) {
    std::vector<std::size_t> row(other.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= word.size(); ++i) {
      std::size_t diagonal = std::exchange(row[0], i);
      for (std::size_t j = 1; j <= other.size(); ++j) {
        const std::size_t change = diagonal + (word[i - 1] == other[j - 1] ? 0 : 1);
        diagonal = std::exchange(row[j], std::min({row[j] + 1, row[j - 1] + 1, change}));
      }
    }
    return row.back();
  };
  const auto best = std::min_element(candidates.begin(), candidates.end(),
                                     [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  return best == candidates.end() ? std::string() : *best;
}

}  // namespace feder::experiments
