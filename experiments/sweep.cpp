// A scene over many settings: one `simulate` process per case, one table for all of them.

#include <fmt/format.h>

#include <cstdio>
#include <string_view>

#include "experiments/support/sweep_merge.h"
#include "experiments/support/sweep_options.h"
#include "experiments/support/timing.h"

namespace {

using namespace feder::experiments;

Ending sweep(int argc, char** argv) {
  const std::optional<SweepOptions> options = parse_sweep(argc, argv);
  if (!options) return {};
  if (!options->dry_run) return run_sweep(options->plan, options->run);
  std::fputs(describe(options->plan, options->run).c_str(), stdout);
  return {};
}

Ending merge(int argc, char** argv) {
  const std::optional<MergeOptions> options = parse_merge(argc, argv);
  if (!options) return {};
  const Stopwatch watch;
  const SweepResult whole = merge_shards(options->folders);
  create_folder(options->out);
  write_plan(whole.plan, options->out);
  write_sweep(whole.plan, whole.table, options->out, {}, watch.seconds());
  if (!options->quiet) {
    fmt::print("{}\nResults are in {}\n", count_by_status(whole.table, whole.plan.cases.size()),
               options->out.string());
  }
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  fix_environment();
  const bool merging = argc > 1 && std::string_view(argv[1]) == "merge";
  return report("sweep", guarded([&] { return merging ? merge(argc - 1, argv + 1) : sweep(argc, argv); }));
}
