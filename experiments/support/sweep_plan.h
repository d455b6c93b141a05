#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace feder::experiments {

/// One run of `simulate`. Empty values leave what the scene file says.
struct SweepCase {
  std::string id;                   ///< 16 hexadecimal digits, a hash of the key and value texts
  std::vector<std::string> values;  ///< one per key of the plan
};

/// Part `index` (1 .. count) of a sweep; the case at position p belongs to part p mod count + 1.
struct Shard {
  int index = 1;
  int count = 1;

  bool owns(std::size_t position) const;
  bool operator==(const Shard&) const = default;
};

/// A key with its values, as texts.
struct SweepAxis {
  std::string key;
  std::vector<std::string> values;
};

/// Everything that decides the results of a sweep, and which part of it is run here.
struct SweepPlan {
  std::string scene = {};       ///< path as given
  std::string scene_hash = {};  ///< text_hash() of the file
  std::vector<std::string> keys = {};
  std::vector<std::pair<std::string, std::string>> fixed = {};  ///< the same for all cases
  std::string preset = "full";
  int threads = 1;
  bool reference = false;
  Shard shard = {};
  std::vector<SweepCase> cases = {};  ///< of all shards, in the order of the table
  std::vector<std::string> arguments =
      {};  ///< the command line that makes this plan, without shard and folder
};

/// "key=a,b,c", "key=lo:hi:count" (logarithmic) or "key=lo:hi:count:lin"; words and grids mix. Words keep
/// their text, commas inside brackets do not separate. Throws InputError.
SweepAxis parse_axis(const std::string& text);

/// "key=value". Throws InputError.
std::pair<std::string, std::string> parse_fixed(const std::string& text);

/// "i/n" with 1 <= i <= n. Throws InputError.
Shard parse_shard(const std::string& text);

/// Sets keys and cases to the Cartesian product, the last axis running fastest. Throws InputError for a key
/// that appears twice or is a column of the table, for equal cases and for more than a million of them.
void set_grid(SweepPlan& plan, const std::vector<SweepAxis>& axes);

/// Sets keys and cases from CSV text: keys in the header, one case per line. `place` names the source in an
/// InputError.
void set_list(SweepPlan& plan, std::string_view csv, const std::string& place);

/// Number of cases in the plan's own shard.
std::size_t shard_size(const SweepPlan& plan);

/// "method.dt=1e-3 end_time=2", the words of a case.
std::string describe(const SweepPlan& plan, const SweepCase& one);

/// The `simulate` command of a case that writes to `folder`.
std::vector<std::string> command_of(const SweepPlan& plan, const SweepCase& one, const std::string& simulate,
                                    const std::filesystem::path& folder);

/// Hash of everything that decides the result of one case: a stored result with another one is stale.
std::string fingerprint(const SweepPlan& plan, const SweepCase& one);

/// The text of plan.json, and back. InputError names `place`.
std::string plan_json(const SweepPlan& plan);
SweepPlan parse_plan(std::string_view text, const std::string& place);

/// Empty if both are parts of the same sweep, otherwise what differs.
std::string difference(const SweepPlan& a, const SweepPlan& b);

}  // namespace feder::experiments
