#include "experiments/support/command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "engine/check.h"
#include "experiments/support/build_info.h"

namespace feder::experiments {
namespace {

std::string version_line(const std::string& program) {
  const BuildInfo build = build_info();
  return fmt::format("feder {} {} (commit {}{})", program, build.version, build.commit,
                     build.dirty == "yes" ? ", with local changes" : "");
}

void print(const std::string& text) {
  std::fputs((text + "\n").c_str(), stdout);
  std::fflush(stdout);
}

}  // namespace

bool parse_command_line(CLI::App& app, int argc, char** argv) {
  app.set_version_flag("--version", version_line(app.get_name()), "Print version and commit");
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    print(app.help());
    return false;
  } catch (const CLI::CallForVersion&) {
    print(version_line(app.get_name()));
    return false;
  } catch (const CLI::ParseError& error) {
    throw InputError(std::string(error.what()) + " (see --help)");
  }
  return true;
}

}  // namespace feder::experiments
