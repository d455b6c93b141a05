#include "experiments/support/sweep_options.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>

#include "experiments/support/command_line.h"
#include "experiments/support/hash.h"

namespace feder::experiments {
namespace {

constexpr int kMostJobs = 4096;

constexpr const char* kHelp =
    R"(Values: --grid key=a,b,c takes texts (commas inside brackets do not separate), lo:hi:count is a logarithmic
and lo:hi:count:lin a linear grid; several --grid make the Cartesian product. In a --list file an empty
field leaves what the scene says.

A case that fails is a row with status and reason. The same command again skips the cases that are done,
runs interrupted ones, those with io_error and those whose time limit was shorter; to repeat a case, delete
DIR/cases/ID. Files that the scene refers to are not watched: after changing one, choose another --out.
Timings are undisturbed with --jobs 1 only.

Examples:
  sweep rope.toml --grid method.integrator=leapfrog,rk4 --grid method.dt=1e-5:1e-2:13 --jobs 4 --out rope

  Slurm, one shard per array task, then all of them joined:
    #SBATCH --array=1-20
    sweep rope.toml --grid method.dt=1e-6:1e-2:200 --shard $SLURM_ARRAY_TASK_ID/20 \
          --jobs $SLURM_CPUS_PER_TASK --quiet --out rope/shard$SLURM_ARRAY_TASK_ID
    sweep merge rope/shard* --out rope/all

  GNU parallel, four shards on three machines with a common folder (the same directory everywhere):
    parallel -S host1,host2,host3 --workdir . \
          sweep rope.toml --grid method.dt=1e-6:1e-2:200 --shard {}/4 --out rope/shard{} ::: 1 2 3 4
    sweep merge rope/shard* --out rope/all

)";

/// What the command line says, before it is checked against anything.
struct Raw {
  std::vector<std::string> grids;
  std::vector<std::string> fixed;
  std::string list;
  std::string shard = "1/1";
  std::string simulate;
  std::string out = "results/sweep";
};

void add_repeated(CLI::App& app, const std::string& name, std::vector<std::string>& into, const char* form,
                  const char* description) {
  app.add_option(name, into, description)
      ->option_text(form)
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

void add_options(CLI::App& app, SweepOptions& options, Raw& raw) {
  app.footer(std::string(kHelp) + kExitCodes);
  app.add_option("scene", options.plan.scene, "Scene file")->required()->option_text("SCENE.toml");
  add_repeated(app, "--grid", raw.grids, "KEY=VALUES",
               "Values of a key of the scene or method; may be repeated");
  app.add_option("--list", raw.list, "Cases instead of a grid: keys in the header, one case per line")
      ->option_text("FILE.csv")
      ->excludes("--grid");
  add_repeated(app, "--set", raw.fixed, "KEY=VALUE", "The same for all cases; may be repeated");
  app.add_option("--preset", options.plan.preset, "quick or full, passed on")
      ->capture_default_str()
      ->check(CLI::IsMember({"quick", "full"}));
  app.add_flag("--reference", options.plan.reference, "Compare each case with the judge");
  app.add_option("--jobs", options.run.jobs, "Cases at a time")
      ->capture_default_str()
      ->check(CLI::Range(1, kMostJobs));
  app.add_option("--threads", options.plan.threads, "Threads of each case")
      ->capture_default_str()
      ->check(CLI::Range(1, kMostThreads));
  app.add_option("--timeout", options.run.limit, "Wall time of one case, s")->capture_default_str();
  app.add_option("--shard", raw.shard, "Run part i of n only")->option_text("I/N");
  app.add_option("--out", raw.out, "Folder for the results")->capture_default_str();
  app.add_option("--simulate", raw.simulate, "The program to run (default: simulate beside this one)");
  app.add_flag("--dry-run", options.dry_run, "Print the cases and the expected time, run nothing");
  app.add_flag("--quiet", options.run.quiet, "Print errors only");
}

/// `simulate` in the folder of this program, unless another one is asked for.
std::string find_simulate(const std::string& given) {
  std::filesystem::path path = given;
  if (given.empty()) {
    std::error_code ignored;
    path = std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path() / "simulate";
  }
  path = std::filesystem::absolute(path);
  if (!std::filesystem::is_regular_file(path) || ::access(path.c_str(), X_OK) != 0)
    throw InputError(fmt::format("--simulate: '{}' is not a program that can be run", path.string()));
  return path.string();
}

std::string read_input(const std::string& what, const std::string& path) {
  if (!std::filesystem::is_regular_file(path))
    throw InputError(fmt::format("{}: there is no file '{}'", what, path));
  return read_file(path);
}

/// The part of the command line that makes the plan.
std::vector<std::string> arguments_of(const SweepPlan& plan, const Raw& raw) {
  std::vector<std::string> words = {plan.scene};
  const auto add = [&](const char* option, const std::string& value) {
    words.insert(words.end(), {option, value});
  };
  for (const std::string& grid : raw.grids) add("--grid", grid);
  if (!raw.list.empty()) add("--list", raw.list);
  for (const std::string& change : raw.fixed) add("--set", change);
  if (plan.preset != SweepPlan{}.preset) add("--preset", plan.preset);
  if (plan.threads != 1) add("--threads", std::to_string(plan.threads));
  if (plan.reference) words.push_back("--reference");
  return words;
}

void complete(SweepOptions& options, const Raw& raw) {
  SweepPlan& plan = options.plan;
  if (raw.grids.empty() && raw.list.empty())
    throw InputError("nothing to sweep: expected --grid key=values or --list FILE.csv");
  require_positive("the command line", "--timeout", options.run.limit, "s");
  plan.scene_hash = text_hash(read_input("the scene", plan.scene));
  plan.shard = parse_shard(raw.shard);
  for (const std::string& change : raw.fixed) plan.fixed.push_back(parse_fixed(change));
  std::vector<SweepAxis> axes;
  for (const std::string& grid : raw.grids) axes.push_back(parse_axis(grid));
  if (raw.list.empty()) {
    set_grid(plan, axes);
  } else {
    set_list(plan, read_input("--list", raw.list), raw.list);
  }
  plan.arguments = arguments_of(plan, raw);
  options.run.out = raw.out;
  options.run.simulate = options.dry_run ? raw.simulate : find_simulate(raw.simulate);
}

}  // namespace

std::optional<SweepOptions> parse_sweep(int argc, char** argv) {
  SweepOptions options;
  Raw raw;
  CLI::App app(
      "Runs a scene over many settings, several cases at a time, and gathers one table.\n"
      "sweep merge DIR... --out DIR joins the shards of a sweep.",
      "sweep");
  add_options(app, options, raw);
  if (!parse_command_line(app, argc, argv)) return std::nullopt;
  complete(options, raw);
  return options;
}

std::optional<MergeOptions> parse_merge(int argc, char** argv) {
  MergeOptions options;
  std::vector<std::string> folders;
  std::string out;
  CLI::App app("Joins the shards of a sweep into one table, if they are complete.", "sweep merge");
  app.footer(kExitCodes);
  app.add_option("folders", folders, "Folders of the shards")->required()->option_text("DIR...");
  app.add_option("--out", out, "Folder for the whole sweep")->required()->option_text("DIR");
  app.add_flag("--quiet", options.quiet, "Print errors only");
  if (!parse_command_line(app, argc, argv)) return std::nullopt;
  for (const std::string& folder : folders) {
    std::error_code ignored;
    if (std::filesystem::equivalent(folder, out, ignored))
      throw InputError(fmt::format("--out: '{}' is one of the shards", out));
    options.folders.emplace_back(folder);
  }
  options.out = out;
  return options;
}

}  // namespace feder::experiments
