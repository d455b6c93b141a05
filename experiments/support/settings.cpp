#include "experiments/support/settings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "engine/check.h"

namespace feder::experiments {
namespace {

std::string place_of(std::string_view key) {
  return fmt::format("setting '{}'", key);
}

void require_choice(const Setting& setting, const std::string& word) {
  const std::vector<std::string>& choices = setting.choices;
  if (choices.empty() || std::find(choices.begin(), choices.end(), word) != choices.end()) return;
  throw InputError(fmt::format("{}: got '{}', expected one of {}; nearest is '{}'", place_of(setting.key),
                               word, fmt::join(choices, ", "), nearest(word, choices)));
}

/// Throws InputError unless the value is of the declared kind.
void require_kind(const Setting& setting, const std::string& value) {
  const std::string place = place_of(setting.key);
  switch (setting.kind) {
    case Kind::kNumber:
      parse_number(place, value);
      return;
    case Kind::kInteger:
      parse_integer(place, value);
      return;
    case Kind::kNumbers:
      parse_numbers(place, value);
      return;
    case Kind::kText:
      require_choice(setting, value);
      return;
    case Kind::kTexts:
      for (const std::string& word : parse_texts(place, value)) require_choice(setting, word);
      return;
  }
}

}  // namespace

Settings::Settings(std::vector<Setting> declared, const std::string& preset,
                   const std::vector<std::string>& changes)
    : declared_(std::move(declared)) {
  if (preset != "quick" && preset != "full") {
    throw InputError(fmt::format("preset: got '{}', expected quick or full; nearest is '{}'", preset,
                                 nearest(preset, {"quick", "full"})));
  }
  for (const Setting& setting : declared_) {
    const bool is_new = values_.emplace(setting.key, preset == "quick" ? setting.quick : setting.full).second;
    if (!is_new) throw MisuseError("the setting '" + setting.key + "' is declared twice");
  }
  for (const std::string& change : changes) set(change);
  for (const Setting& setting : declared_) require_kind(setting, values_.at(setting.key));
}

void Settings::set(const std::string& change) {
  const std::size_t equals = change.find('=');
  if (equals == std::string::npos)
    throw InputError(fmt::format("--set: got '{}', expected key=value", change));
  const std::string key = change.substr(0, equals);
  const auto found = values_.find(key);
  if (found == values_.end()) {
    std::vector<std::string> keys;
    for (const Setting& setting : declared_) keys.push_back(setting.key);
    const std::string hint =
        keys.empty() ? "this experiment has none" : "nearest is '" + nearest(key, keys) + "'";
    throw InputError(fmt::format("--set {}: unknown setting '{}'; {}", change, key, hint));
  }
  found->second = change.substr(equals + 1);
}

const std::string& Settings::value(std::string_view key, Kind kind) const {
  for (const Setting& setting : declared_) {
    if (setting.key == key && setting.kind == kind) return values_.find(key)->second;
  }
  throw MisuseError(fmt::format("the setting '{}' is not declared with the kind it is read with", key));
}

double Settings::number(std::string_view key) const {
  return parse_number(place_of(key), value(key, Kind::kNumber));
}

std::int64_t Settings::integer(std::string_view key) const {
  return parse_integer(place_of(key), value(key, Kind::kInteger));
}

const std::string& Settings::text(std::string_view key) const {
  return value(key, Kind::kText);
}

std::vector<double> Settings::numbers(std::string_view key) const {
  return parse_numbers(place_of(key), value(key, Kind::kNumbers));
}

std::vector<std::string> Settings::texts(std::string_view key) const {
  return parse_texts(place_of(key), value(key, Kind::kTexts));
}

}  // namespace feder::experiments
