#include "experiments/support/options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "experiments/support/command_line.h"

namespace feder::experiments {
namespace {

std::string settings_help(const ExperimentInfo& info) {
  std::string text = "Settings for --set, with their value in the presets:\n";
  for (const Setting& setting : info.settings) {
    text += fmt::format("  {:<16} {}\n  {:<16} quick: {}\n  {:<16} full:  {}\n", setting.key,
                        setting.description, "", setting.quick, "", setting.full);
    if (!setting.choices.empty())
      text += fmt::format("  {:<16} words: {}\n", "", fmt::join(setting.choices, ", "));
  }
  return text +
         "Lists are a,b,c; number lists may be grids lo:hi:count (logarithmic) or lo:hi:count:lin.\n\nDoes "
         "not model: " +
         info.not_modelled + "\n\n" + kExitCodes;
}

}  // namespace

std::optional<Options> parse_options(const ExperimentInfo& info, int argc, char** argv) {
  Options options;
  options.out = "results/" + info.name;
  CLI::App app(info.question, info.name);
  app.footer(settings_help(info));
  app.add_flag("--list", options.list, "List the cases");
  app.add_flag("--dry-run", options.dry_run, "Print the resolved options and the cases, run nothing");
  app.add_option("--preset", options.preset, "quick (seconds) or full")->capture_default_str();
  app.add_option("--set", options.changes, "Change a setting; may be repeated")
      ->option_text("KEY=VALUE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--seed", options.seed, "Seed of every random choice")->capture_default_str();
  app.add_option("--out", options.out, "Folder for the results")->capture_default_str();
  app.add_option("--threads", options.threads, "Threads of the linear algebra")
      ->capture_default_str()
      ->check(CLI::Range(1, kMostThreads));
  app.add_flag("--quiet", options.quiet, "Print errors only");
  if (!parse_command_line(app, argc, argv)) return std::nullopt;
  return options;
}

std::string describe(const ExperimentInfo& info, const Options& options, const Settings& settings) {
  std::string text =
      fmt::format("{}: {}\npreset   {}\nseed     {}\nthreads  {}\nout      {}\nsettings\n", info.name,
                  info.question, options.preset, options.seed, options.threads, options.out);
  for (const Setting& setting : settings.declared()) {
    text += fmt::format("  {} = {}   ({})\n", setting.key, settings.values().at(setting.key),
                        setting.description);
  }
  text += "cases\n";
  for (const std::string& name : info.cases) text += "  " + name + "\n";
  return text;
}

}  // namespace feder::experiments
