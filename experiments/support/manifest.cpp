#include "experiments/support/manifest.h"

#include <fmt/chrono.h>

#include <fstream>

#include "experiments/support/build_info.h"
#include "experiments/support/manifest_parts.h"
#include "solvers/threads.h"

namespace feder::experiments {

using Json = nlohmann::ordered_json;

namespace {

Json options_json(const Options& options, const Context& context) {
  return {{"preset", options.preset},
          {"seed", options.seed},
          {"threads", options.threads},
          {"out", options.out},
          {"settings", context.settings.values()}};
}

Json charts_json(const Context& context) {
  Json charts = Json::array();
  for (const Chart& chart : context.charts()) {
    charts.push_back({{"name", chart.name}, {"title", chart.title}, {"caption", chart.caption}});
  }
  return charts;
}

Json extra_tables_json(const Context& context) {
  Json names = Json::array();
  for (const auto& [name, table] : context.extra_tables()) names.push_back(name);
  return names;
}

}  // namespace

Json build_json() {
  const BuildInfo build = build_info();
  return {{"version", build.version},   {"commit", build.commit},        {"local_changes", build.dirty},
          {"compiler", build.compiler}, {"compiler_flags", build.flags}, {"build_type", build.build_type}};
}

Json machine_json(int threads) {
  return {
      {"cpu", cpu_model()}, {"threads", threads}, {"blas", blas_name()}, {"libraries", library_versions()}};
}

std::string manifest_json(const ExperimentInfo& info, const Options& options, const Context& context,
                          const Outcome& outcome) {
  const Json manifest = {{"program", info.name},
                         {"question", info.question},
                         {"does_not_model", info.not_modelled},
                         {"status", outcome.status},
                         {"reason", outcome.reason},
                         {"started", utc_time(outcome.started)},
                         {"wall_seconds", outcome.wall_seconds},
                         {"options", options_json(options, context)},
                         {"build", build_json()},
                         {"machine", machine_json(context.threads)},
                         {"table", info.name + ".csv"},
                         {"results_hash", results_hash(context.table)},
                         {"charts", charts_json(context)},
                         {"extra_tables", extra_tables_json(context)},
                         {"notes", context.notes()}};
  // Text from the command line need not be valid UTF-8.
  return manifest.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string utc_time(std::chrono::system_clock::time_point time) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::chrono::system_clock::to_time_t(time)));
}

std::string cpu_model() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

}  // namespace feder::experiments
