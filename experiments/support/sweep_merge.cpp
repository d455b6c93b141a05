#include "experiments/support/sweep_merge.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "engine/check.h"
#include "experiments/support/files.h"

namespace feder::experiments {
namespace {

constexpr std::size_t kMostNamed = 20;

struct Part {
  std::filesystem::path folder;
  SweepPlan plan;
  Table table;
};

Part read_part(const std::filesystem::path& folder) {
  const std::filesystem::path plan = folder / "plan.json", table = folder / "sweep.csv";
  Part part{folder, parse_plan(read_file(plan), plan.string()), from_csv(read_file(table), table.string())};
  if (part.table.columns() != sweep_table(part.plan).columns())
    throw InputError(table.string() + ": its columns are not those of plan.json");
  return part;
}

/// Where the finished rows of a case are.
struct Place {
  std::size_t part;
  std::size_t row;
};

std::map<std::string, std::vector<Place>> find_rows(const std::vector<Part>& parts) {
  std::map<std::string, std::vector<Place>> places;
  for (const SweepCase& one : parts.front().plan.cases) places[one.id];
  for (std::size_t p = 0; p < parts.size(); ++p) {
    for (std::size_t row = 0; row < parts[p].table.rows(); ++row) {
      const std::string id = parts[p].table.at(row, "case").text();
      const auto found = places.find(id);
      if (found == places.end())
        throw InputError(fmt::format("{}: the case '{}' is not in the plan", parts[p].folder.string(), id));
      if (parts[p].table.at(row, "status").text() != "interrupted") found->second.push_back({p, row});
    }
  }
  return places;
}

std::string shell_word(const std::string& word) {
  constexpr const char* kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=.,:/@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string quoted = "'";
  for (const char c : word) {
    if (c == '\'') quoted += "'\\'";
    quoted += c;
  }
  return quoted += '\'';
}

/// The command that runs shard `index` again, into the folder it has if it is known.
std::string rerun(const std::vector<Part>& parts, Shard shard) {
  std::string out = "DIR";
  for (const Part& part : parts) {
    if (part.plan.shard == shard) out = shell_word(part.folder.string());
  }
  std::string command = "sweep";
  for (const std::string& word : parts.front().plan.arguments)
    command += fmt::format(" {}", shell_word(word));
  if (shard.count > 1) command += fmt::format(" --shard {}/{}", shard.index, shard.count);
  return command + " --out " + out;
}

/// A list of complaints, the first ones in full.
class Complaints {
 public:
  void add(const std::string& line) {
    if (++count_ <= kMostNamed) text_ += "\n  " + line;
  }
  bool any() const { return count_ > 0; }
  std::string text() const {
    return count_ > kMostNamed ? text_ + fmt::format("\n  and {} more", count_ - kMostNamed) : text_;
  }

 private:
  std::size_t count_ = 0;
  std::string text_;
};

void require_complete(const std::vector<Part>& parts, std::map<std::string, std::vector<Place>>& places) {
  const SweepPlan& plan = parts.front().plan;
  Complaints missing, twice, commands;
  std::vector<int> shards;
  for (std::size_t i = 0; i < plan.cases.size(); ++i) {
    const std::vector<Place>& found = places[plan.cases[i].id];
    const std::string name = plan.cases[i].id + "  " + describe(plan, plan.cases[i]);
    if (found.size() == 1) continue;
    if (found.size() > 1) {
      twice.add(fmt::format("{}  in {} and {}", name, parts[found[0].part].folder.string(),
                            parts[found[1].part].folder.string()));
      continue;
    }
    missing.add(name);
    const int shard = static_cast<int>(i % static_cast<std::size_t>(plan.shard.count)) + 1;
    if (std::find(shards.begin(), shards.end(), shard) == shards.end()) shards.push_back(shard);
  }
  for (const int shard : shards) commands.add(rerun(parts, {shard, plan.shard.count}));
  if (!missing.any() && !twice.any()) return;
  std::string text = "the shards are not one whole sweep";
  if (missing.any())
    text +=
        "\nmissing:" + missing.text() + "\nto run them, with DIR a folder of your choice:" + commands.text();
  if (twice.any()) text += "\nthere twice:" + twice.text() + "\nleave one of the folders out";
  throw IoError(text);
}

}  // namespace

SweepResult merge_shards(const std::vector<std::filesystem::path>& folders) {
  std::vector<Part> parts;
  for (const std::filesystem::path& folder : folders) parts.push_back(read_part(folder));
  FEDER_CHECK(!parts.empty(), "no folders to merge");
  for (const Part& part : parts) {
    const std::string what = difference(parts.front().plan, part.plan);
    if (!what.empty())
      throw InputError(fmt::format("'{}' and '{}' hold different sweeps: {} differ", folders.front().string(),
                                   part.folder.string(), what));
  }
  std::map<std::string, std::vector<Place>> places = find_rows(parts);
  require_complete(parts, places);
  SweepResult result{parts.front().plan, sweep_table(parts.front().plan)};
  result.plan.shard = {};
  for (const SweepCase& one : result.plan.cases) {
    const Place place = places.at(one.id).front();
    Table::Row row;
    for (const std::string& column : result.table.columns())
      row.emplace_back(column, parts[place.part].table.at(place.row, column));
    result.table.add(row);
  }
  return result;
}

}  // namespace feder::experiments
