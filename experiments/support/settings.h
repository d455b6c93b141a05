#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace feder::experiments {

/// What `--set key=value` accepts. Lists: "0.1,0.05" or, for numbers, the grids "lo:hi:count" (logarithmic)
/// and "lo:hi:count:lin".
enum class Kind { kNumber, kInteger, kText, kNumbers, kTexts };

/// One setting of an experiment with its value in each preset.
struct Setting {
  std::string key = {};
  Kind kind = Kind::kNumber;
  std::string quick = {};
  std::string full = {};
  std::string description = {};           ///< with the unit: "time steps, s"
  std::vector<std::string> choices = {};  ///< for texts: the allowed words, empty for any
};

/// The resolved settings of a run. Everything is checked in the constructor, before the first step.
class Settings {
 public:
  Settings() = default;
  /// `changes` are "key=value" texts on top of the preset ("quick" or "full"). InputError names key, value
  /// and what was expected, and for an unknown key the nearest valid one.
  Settings(std::vector<Setting> declared, const std::string& preset, const std::vector<std::string>& changes);

  // MisuseError if the key is not declared with this kind.
  double number(std::string_view key) const;
  std::int64_t integer(std::string_view key) const;
  const std::string& text(std::string_view key) const;
  std::vector<double> numbers(std::string_view key) const;
  std::vector<std::string> texts(std::string_view key) const;

  const std::vector<Setting>& declared() const { return declared_; }
  /// Key to value as given, for the manifest.
  const std::map<std::string, std::string, std::less<>>& values() const { return values_; }

 private:
  const std::string& value(std::string_view key, Kind kind) const;
  void set(const std::string& change);

  std::vector<Setting> declared_;
  std::map<std::string, std::string, std::less<>> values_;
};

/// The candidate with the smallest edit distance; empty when there is none.
std::string nearest(std::string_view word, const std::vector<std::string>& candidates);

// Parsers behind the settings. InputError: "<place>: got '<text>', expected ...".
double parse_number(const std::string& place, std::string_view text);
std::int64_t parse_integer(const std::string& place, std::string_view text);
std::vector<double> parse_numbers(const std::string& place, std::string_view text);
std::vector<std::string> parse_texts(const std::string& place, std::string_view text);

}  // namespace feder::experiments
