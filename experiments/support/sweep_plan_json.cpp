#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "engine/check.h"
#include "experiments/support/sweep_plan.h"

namespace feder::experiments {
namespace {

using Json = nlohmann::ordered_json;

std::vector<std::pair<std::string, std::string>> sorted(
    std::vector<std::pair<std::string, std::string>> pairs) {
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

bool same_cases(const SweepPlan& a, const SweepPlan& b) {
  return std::equal(a.cases.begin(), a.cases.end(), b.cases.begin(), b.cases.end(),
                    [](const SweepCase& x, const SweepCase& y) { return x.values == y.values; });
}

}  // namespace

std::string plan_json(const SweepPlan& plan) {
  Json cases = Json::array();
  for (const SweepCase& one : plan.cases) cases.push_back({{"id", one.id}, {"values", one.values}});
  const Json json = {{"program", "sweep"},
                     {"scene", plan.scene},
                     {"scene_hash", plan.scene_hash},
                     {"fixed", plan.fixed},
                     {"preset", plan.preset},
                     {"threads", plan.threads},
                     {"reference", plan.reference},
                     {"shard", {{"index", plan.shard.index}, {"count", plan.shard.count}}},
                     {"arguments", plan.arguments},
                     {"keys", plan.keys},
                     {"cases", cases}};
  try {
    return json.dump(1) + "\n";
  } catch (const Json::exception&) {
    throw InputError("the plan holds text that is not UTF-8");
  }
}

SweepPlan parse_plan(std::string_view text, const std::string& place) {
  try {
    const Json json = Json::parse(text);
    SweepPlan plan;
    json.at("scene").get_to(plan.scene);
    json.at("scene_hash").get_to(plan.scene_hash);
    json.at("fixed").get_to(plan.fixed);
    json.at("preset").get_to(plan.preset);
    json.at("threads").get_to(plan.threads);
    json.at("reference").get_to(plan.reference);
    plan.shard = {json.at("shard").at("index").get<int>(), json.at("shard").at("count").get<int>()};
    json.at("arguments").get_to(plan.arguments);
    json.at("keys").get_to(plan.keys);
    for (const Json& one : json.at("cases"))
      plan.cases.push_back(
          {one.at("id").get<std::string>(), one.at("values").get<std::vector<std::string>>()});
    const bool whole = std::all_of(plan.cases.begin(), plan.cases.end(), [&](const SweepCase& one) {
      return one.values.size() == plan.keys.size();
    });
    if (!whole || plan.shard.index < 1 || plan.shard.index > plan.shard.count)
      throw InputError(place + ": not the plan of a sweep");
    return plan;
  } catch (const Json::exception& error) {
    throw InputError(fmt::format("{}: not the plan of a sweep: {}", place, error.what()));
  }
}

std::string difference(const SweepPlan& a, const SweepPlan& b) {
  if (a.scene_hash != b.scene_hash) return "the text of the scene";
  if (a.keys != b.keys) return "the keys";
  if (!same_cases(a, b)) return "the cases";
  if (sorted(a.fixed) != sorted(b.fixed)) return "the values of --set";
  if (a.preset != b.preset) return "the preset";
  if (a.threads != b.threads) return "the threads";
  if (a.reference != b.reference) return "--reference";
  return "";
}

}  // namespace feder::experiments
