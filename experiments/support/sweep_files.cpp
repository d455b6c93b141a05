#include <fmt/format.h>

#include "experiments/support/manifest.h"
#include "experiments/support/manifest_parts.h"
#include "experiments/support/sweep_run.h"
#include "experiments/support/sweep_table.h"

namespace feder::experiments {

void write_plan(const SweepPlan& plan, const std::filesystem::path& out) {
  const std::filesystem::path path = out / "plan.json";
  const std::string text = plan_json(plan);
  if (std::filesystem::exists(path) && read_file(path) != text) {
    std::filesystem::remove(out / "sweep.csv");
    std::filesystem::remove(out / "manifest.json");
  }
  write_file(path, text);
}

void write_sweep(const SweepPlan& plan, const Table& table, const std::filesystem::path& out,
                 const Ending& ending, double wall_seconds) {
  using Json = nlohmann::ordered_json;
  using std::chrono::system_clock;
  const auto started = system_clock::now() - std::chrono::duration_cast<system_clock::duration>(
                                                 std::chrono::duration<double>(wall_seconds));
  const Json manifest = {{"program", "sweep"},
                         {"question", fmt::format("What do these cases of {} give?", plan.scene)},
                         {"does_not_model", "Whatever the scene leaves out."},
                         {"status", ending.status},
                         {"reason", ending.reason},
                         {"started", utc_time(started)},
                         {"wall_seconds", wall_seconds},
                         {"options",
                          {{"scene", plan.scene},
                           {"scene_hash", plan.scene_hash},
                           {"preset", plan.preset},
                           {"threads", plan.threads},
                           {"arguments", plan.arguments},
                           {"shard", fmt::format("{}/{}", plan.shard.index, plan.shard.count)}}},
                         {"build", build_json()},
                         {"machine", machine_json(plan.threads)},
                         {"table", "sweep.csv"},
                         {"results_hash", results_hash(table)},
                         {"notes", {count_by_status(table, shard_size(plan))}}};
  write_csv(table, out / "sweep.csv");
  write_file(out / "manifest.json", manifest.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace feder::experiments
