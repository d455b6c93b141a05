#include "experiments/support/sweep_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <unordered_set>

#include "engine/check.h"
#include "experiments/support/hash.h"
#include "experiments/support/settings.h"
#include "experiments/support/sweep_table.h"

namespace feder::experiments {
namespace {

constexpr std::size_t kMostCases = 1000000;
constexpr int kMostShards = 1000000;

/// Writes every text with its length, so that no two lists of texts look alike.
std::string joined(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += fmt::format("{}:{}", text.size(), text);
  return all;
}

/// Key and value texts of a case, whatever the order of the keys.
std::vector<std::string> sorted_pairs(const SweepPlan& plan, const SweepCase& one) {
  std::vector<std::string> pairs;
  for (std::size_t i = 0; i < plan.keys.size(); ++i) pairs.push_back(joined({plan.keys[i], one.values[i]}));
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

void require_printable(const std::string& place, const std::string& text) {
  const bool control =
      std::any_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; });
  if (control) throw InputError(place + ": holds a control character, expected printable text");
}

void require_key(const std::string& place, const std::string& key) {
  require_printable(place, key);
  if (key.empty() || key.front() == '-' || key.find_first_of("= \"',") != std::string::npos)
    throw InputError(fmt::format("{}: got the key '{}', expected a dotted key like method.dt", place, key));
}

std::pair<std::string, std::string> key_and_value(const std::string& place, const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos)
    throw InputError(fmt::format("{}: got '{}', expected key=value", place, text));
  std::pair<std::string, std::string> pair = {text.substr(0, equals), text.substr(equals + 1)};
  require_key(place, pair.first);
  require_printable(place + " " + pair.first, pair.second);
  if (pair.second.empty()) throw InputError(fmt::format("{} {}: no value", place, pair.first));
  return pair;
}

/// "1e-3:..." is meant as a grid, "steel:hard" is a word.
bool is_grid(const std::string& word) {
  const std::size_t colon = word.find(':');
  if (colon == std::string::npos) return false;
  try {
    (void)parse_number("", std::string_view(word).substr(0, colon));
    return true;
  } catch (const InputError&) {
    return false;
  }
}

void require_distinct_keys(const SweepPlan& plan) {
  std::set<std::string> taken = {"case"};
  taken.insert(result_columns().begin(), result_columns().end());
  for (const std::string& key : plan.keys) {
    if (taken.insert(key).second) continue;
    const bool twice = std::count(plan.keys.begin(), plan.keys.end(), key) > 1;
    throw InputError(
        fmt::format("the key '{}' {}", key, twice ? "is swept twice" : "is the name of a result column"));
  }
  std::set<std::string> fixed;
  for (const auto& [key, value] : plan.fixed) {
    if (!fixed.insert(key).second) throw InputError(fmt::format("--set {}: the key is set twice", key));
    if (std::find(plan.keys.begin(), plan.keys.end(), key) != plan.keys.end())
      throw InputError(fmt::format("--set {}: the key is swept as well", key));
  }
}

void name_cases(SweepPlan& plan) {
  std::unordered_set<std::string> ids;
  for (SweepCase& one : plan.cases) {
    one.id = text_hash(joined(sorted_pairs(plan, one)));
    if (!ids.insert(one.id).second)
      throw InputError(fmt::format("the case {} appears twice", describe(plan, one)));
  }
}

}  // namespace

bool Shard::owns(std::size_t position) const {
  return position % static_cast<std::size_t>(count) == static_cast<std::size_t>(index - 1);
}

SweepAxis parse_axis(const std::string& text) {
  const auto [key, list] = key_and_value("--grid", text);
  const std::string place = "--grid " + key;
  SweepAxis axis{key, {}};
  for (const std::string& word : parse_texts(place, list)) {
    if (!is_grid(word)) {
      axis.values.push_back(word);
      continue;
    }
    for (const double value : parse_numbers(place, word)) axis.values.push_back(fmt::format("{}", value));
  }
  return axis;
}

std::pair<std::string, std::string> parse_fixed(const std::string& text) {
  return key_and_value("--set", text);
}

Shard parse_shard(const std::string& text) {
  const std::string expected =
      fmt::format("--shard: got '{}', expected i/n with 1 <= i <= n <= {}", text, kMostShards);
  const std::size_t slash = text.find('/');
  if (slash == std::string::npos) throw InputError(expected);
  const std::int64_t index = parse_integer(expected, std::string_view(text).substr(0, slash));
  const std::int64_t count = parse_integer(expected, std::string_view(text).substr(slash + 1));
  if (index < 1 || index > count || count > kMostShards) throw InputError(expected);
  return {static_cast<int>(index), static_cast<int>(count)};
}

void set_grid(SweepPlan& plan, const std::vector<SweepAxis>& axes) {
  std::size_t count = 1;
  for (const SweepAxis& axis : axes) {
    plan.keys.push_back(axis.key);
    if (axis.values.size() > kMostCases / count)
      throw InputError(fmt::format("--grid: more than {} cases", kMostCases));
    count *= axis.values.size();
  }
  require_distinct_keys(plan);
  for (std::size_t position = 0; position < count; ++position) {
    SweepCase one{"", std::vector<std::string>(axes.size())};
    std::size_t rest = position;
    for (std::size_t i = axes.size(); i-- > 0;) {
      one.values[i] = axes[i].values[rest % axes[i].values.size()];
      rest /= axes[i].values.size();
    }
    plan.cases.push_back(std::move(one));
  }
  name_cases(plan);
}

void set_list(SweepPlan& plan, std::string_view csv, const std::string& place) {
  const Table list = from_csv(csv, place);
  if (list.rows() == 0) throw InputError(place + ": no cases below the header");
  if (list.rows() > kMostCases) throw InputError(fmt::format("{}: more than {} cases", place, kMostCases));
  plan.keys = list.columns();
  for (const std::string& key : plan.keys) require_key(place, key);
  require_distinct_keys(plan);
  for (std::size_t row = 0; row < list.rows(); ++row) {
    SweepCase one;
    for (const std::string& key : plan.keys) one.values.push_back(list.at(row, key).text());
    const std::string where = fmt::format("{}: record {}", place, row + 2);
    for (const std::string& value : one.values) require_printable(where, value);
    if (std::all_of(one.values.begin(), one.values.end(), [](const auto& v) { return v.empty(); }))
      throw InputError(where + ": sets nothing");
    plan.cases.push_back(std::move(one));
  }
  name_cases(plan);
}

std::size_t shard_size(const SweepPlan& plan) {
  const auto before = static_cast<std::size_t>(plan.shard.index - 1);
  const auto count = static_cast<std::size_t>(plan.shard.count);
  return plan.cases.size() > before ? (plan.cases.size() - before + count - 1) / count : 0;
}

std::string describe(const SweepPlan& plan, const SweepCase& one) {
  std::string text;
  for (std::size_t i = 0; i < plan.keys.size(); ++i) {
    if (!one.values[i].empty())
      text += fmt::format("{}{}={}", text.empty() ? "" : " ", plan.keys[i], one.values[i]);
  }
  return text;
}

std::vector<std::string> command_of(const SweepPlan& plan, const SweepCase& one, const std::string& simulate,
                                    const std::filesystem::path& folder) {
  std::vector<std::string> command = {simulate, std::filesystem::absolute(plan.scene).string()};
  const auto set = [&](const std::string& key, const std::string& value) {
    command.push_back("--set");
    command.push_back(key + "=" + value);
  };
  for (const auto& [key, value] : plan.fixed) set(key, value);
  for (std::size_t i = 0; i < plan.keys.size(); ++i) {
    if (!one.values[i].empty()) set(plan.keys[i], one.values[i]);
  }
  for (const std::string& word :
       {std::string("--preset"), plan.preset, std::string("--out"), folder.string(), std::string("--threads"),
        std::to_string(plan.threads), std::string("--quiet")})
    command.push_back(word);
  if (plan.reference) command.push_back("--reference");
  return command;
}

std::string fingerprint(const SweepPlan& plan, const SweepCase& one) {
  std::vector<std::string> texts = {plan.scene_hash, plan.preset, std::to_string(plan.threads),
                                    plan.reference ? "reference" : ""};
  for (const auto& [key, value] : plan.fixed) texts.push_back(joined({key, value}));
  std::sort(texts.begin() + 4, texts.end());
  texts.push_back(joined(sorted_pairs(plan, one)));
  return text_hash(joined(texts));
}

}  // namespace feder::experiments
