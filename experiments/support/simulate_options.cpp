#include "experiments/support/simulate_options.h"

#include <CLI/CLI.hpp>

#include "engine/check.h"
#include "experiments/support/command_line.h"

namespace feder::experiments {
namespace {

constexpr const char* kHelp =
    R"(Keys for --set are those of the scene file with dots: end_time=2, method.dt=1e-3, spring.rope.stiffness=1e5
(entries by name), particle.0.mass=2 (or by number). simulate --keys prints the reference page of all tables.

Into DIR: states.csv (one line per time and particle, point or body), energy.csv, on request trajectory.csv,
trajectory.npy, rows.csv, frames/*.vtu with a .pvd for ParaView; manifest.json, a copy of the scene, and
checkpoint.bin, from which --resume goes on bitwise as if the run had not stopped.

Does not model: contacts and friction.

)";

}  // namespace

std::optional<SimulateOptions> parse_simulate(int argc, char** argv) {
  SimulateOptions options;
  std::string integrator, route, dt;
  CLI::App app("How does this scene move? Runs a scene file and writes its motion as data.", "simulate");
  app.footer(std::string(kHelp) + kExitCodes);
  app.add_option("scene", options.scene, "Scene file")->option_text("SCENE.toml");
  app.add_option("--integrator", integrator, "Short for --set method.integrator=NAME")->option_text("NAME");
  app.add_option("--route", route, "Short for --set method.route=NAME")->option_text("NAME");
  app.add_option("--dt", dt, "Short for --set method.dt=SECONDS")->option_text("SECONDS");
  app.add_option("--set", options.changes, "Change a key of the scene; may be repeated")
      ->option_text("KEY=VALUE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--preset", options.preset, "quick (ends at the scene's quick_end_time) or full")
      ->capture_default_str()
      ->check(CLI::IsMember({"quick", "full"}));
  app.add_flag("--reference", options.reference, "Run the judge, too, and report the error against it");
  app.add_flag("--validate", options.validate, "Only check the file");
  app.add_flag("--explain", options.explain, "Only say what is known of the scene, and what is recommended");
  app.add_flag("--keys", options.keys, "Print the reference page of scene files");
  app.add_flag("--list", options.list, "List integrators and routes");
  app.add_flag("--dry-run", options.dry_run, "Say what would be run, run nothing");
  app.add_flag("--resume", options.resume, "Go on from the checkpoint in DIR");
  app.add_option("--rerun", options.rerun, "Do a run again and compare its results hash")
      ->option_text("MANIFEST.json");
  app.add_flag("--allow-outside", options.allow_outside, "Mesh files may lie outside the scene's folder");
  app.add_option("--seed", options.seed, "Recorded; nothing here is random")->capture_default_str();
  app.add_option("--out", options.out, "Folder for the results")
      ->option_text("DIR=results/scenes/<name of the scene file>");
  app.add_option("--threads", options.threads, "Threads of the linear algebra")
      ->capture_default_str()
      ->check(CLI::Range(1, kMostThreads));
  app.add_flag("--quiet", options.quiet, "Print errors only");
  if (!parse_command_line(app, argc, argv)) return std::nullopt;
  if (!integrator.empty()) options.changes.push_back("method.integrator=" + integrator);
  if (!route.empty()) options.changes.push_back("method.route=" + route);
  if (!dt.empty()) options.changes.push_back("method.dt=" + dt);
  const bool needs_scene = !options.keys && !options.list && options.rerun.empty();
  if (needs_scene && options.scene.empty()) throw InputError("no scene file (see --help)");
  if (!options.rerun.empty() && (!options.scene.empty() || !options.changes.empty() || options.resume))
    throw InputError("--rerun takes scene and settings from the manifest (see --help)");
  if (options.out.empty() && options.rerun.empty())
    options.out = std::filesystem::path("results/scenes") / options.scene.stem();
  return options;
}

}  // namespace feder::experiments
