#include "experiments/support/experiment.h"

#include <fmt/format.h>

#include <cstdio>

#include "experiments/support/files.h"
#include "experiments/support/manifest.h"
#include "experiments/support/options.h"
#include "experiments/support/program.h"
#include "experiments/support/timing.h"
#include "solvers/threads.h"

namespace feder::experiments {
namespace {

Ending run_body(Context& context, const std::function<void(Context&)>& body) {
  Ending ending = guarded([&] {
    body(context);
    return ending_of(context.status());
  });
  context.progress.clear();
  if (ending.code == 0 && context.interrupted()) {
    ending = ending_of(
        Status::failure(StatusCode::kInterrupted, "stopped by a signal; the table holds the runs so far"));
  }
  return ending;
}

// Tables first: a chart that cannot be drawn must not cost the numbers.
void write_results(const ExperimentInfo& info, const Context& context) {
  write_csv(context.table, context.out / (info.name + ".csv"));
  for (const auto& [name, table] : context.extra_tables()) write_csv(table, context.out / (name + ".csv"));
  for (const Chart& chart : context.charts()) draw(chart, context.out);
}

void print_results(Context& context) {
  context.log(to_text(context.table));
  for (const std::string& note : context.notes()) context.log("* " + note);
  context.log(fmt::format("Results are in {}", context.out.string()));
}

Ending run(const ExperimentInfo& info, const Options& options, Settings settings,
           const std::function<void(Context&)>& body) {
  const auto started = std::chrono::system_clock::now();
  const Stopwatch watch;
  create_folder(options.out);
  set_threads(options.threads);
  Context context(std::move(settings), Table(info.columns), options.seed, options.threads, options.out,
                  options.quiet);
  Ending ending = run_body(context, body);
  // Bad input is found before the first step: the results of an earlier run stay as they are.
  if (ending.code == 2) return ending;
  const Ending written = guarded([&] {
    write_results(info, context);
    return Ending{};
  });
  if (ending.code == 0) ending = written;
  const Outcome outcome{ending.status, ending.reason, started, watch.seconds()};
  write_file(context.out / "manifest.json", manifest_json(info, options, context, outcome));
  print_results(context);
  return ending;
}

Ending run_command_line(const ExperimentInfo& info, int argc, char** argv,
                        const std::function<void(Context&)>& body) {
  const std::optional<Options> options = parse_options(info, argc, argv);
  if (!options) return {};
  Settings settings(info.settings, options->preset, options->changes);
  if (options->list) {
    for (const std::string& name : info.cases) std::puts(name.c_str());
    return {};
  }
  if (options->dry_run) {
    std::fputs(describe(info, *options, settings).c_str(), stdout);
    return {};
  }
  return run(info, *options, std::move(settings), body);
}

}  // namespace

int run_experiment(const ExperimentInfo& info, int argc, char** argv,
                   const std::function<void(Context&)>& body) {
  restart_with_better_blas(argv);
  fix_environment();
  return report(info.name, guarded([&] { return run_command_line(info, argc, argv, body); }));
}

}  // namespace feder::experiments
