#include "experiments/support/simulate_manifest.h"

#include <cmath>
#include <cstring>

#include "engine/check.h"
#include "experiments/support/hash.h"
#include "experiments/support/manifest.h"
#include "experiments/support/manifest_parts.h"

namespace feder::experiments {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

Json scene_json(const SimulateRecord& r) {
  return {{"file", std::filesystem::absolute(r.file).lexically_normal().string()},
          {"copy", kSceneCopy},
          {"hash", r.scene_hash},
          {"changes", r.options.changes},
          {"preset", r.options.preset},
          {"allow_outside", r.options.allow_outside}};
}

Json method_json(const Method& m) {
  return {{"integrator", m.integrator},
          {"route", m.options.route},
          {"dt", m.dt},
          {"tolerance", m.tolerance},
          {"newton_tolerance", m.options.newton_tolerance},
          {"most_newton_iterations", m.options.most_newton_iterations},
          {"sweeps", m.options.sweeps},
          {"substeps", m.options.substeps},
          {"rotation_update",
           m.options.rotation_update == RotationUpdate::kExponential ? "exponential" : "normalised_euler"},
          {"max_seconds", m.max_seconds},
          {"divergence", m.divergence}};
}

Json results_json(const SimulateRecord& r) {
  const RunReport& run = r.report;
  Json json = {{"scene", r.scene.model.name},
               {"integrator", run.integrator},
               {"route", run.route},
               {"dt", number(run.dt)},
               {"steps", run.steps},
               {"frames", run.frames},
               {"time", run.state.t},
               {"energy_drift", number(run.energy_drift)},
               {"scene_length", r.scene.model.scene_length},
               {"seconds", run.seconds},
               {"seconds_assemble", run.seconds_assemble},
               {"seconds_factor", run.seconds_factor},
               {"seconds_solve", run.seconds_solve},
               {"seconds_output", run.seconds_output},
               {"files", r.output.files}};
  if (r.reference) {
    json["error"] = number(position_error(r.scene.model.system, run.state, r.reference->state));
    json["reference_error"] = number(r.reference->error);
    json["reference"] = r.reference->method;
  }
  return json;
}

[[noreturn]] void fail_rerun(const std::filesystem::path& path, const std::string& why) {
  throw InputError("--rerun " + path.string() + ": " + why + ", expected a manifest.json of simulate");
}

}  // namespace

std::string manifest_json(const SimulateRecord& r) {
  const Json manifest = {{"program", "simulate"},
                         {"question", "How does this scene move?"},
                         {"does_not_model", "contacts and friction"},
                         {"status", r.ending.status},
                         {"reason", r.ending.reason},
                         {"notes", r.notes},
                         {"started", utc_time(r.started)},
                         {"wall_seconds", r.wall_seconds},
                         {"scene", scene_json(r)},
                         {"options",
                          {{"out", r.options.out.string()},
                           {"threads", r.options.threads},
                           {"seed", r.options.seed},
                           {"reference", r.options.reference},
                           {"resumed", r.options.resume}}},
                         {"method", method_json(r.method)},
                         {"results", results_json(r)},
                         {"units",
                          {{"dt, time", "s"},
                           {"seconds, seconds_...", "s of wall time"},
                           {"error, reference_error, scene_length", "m"},
                           {"energy_drift", "energy scale of the scene"}}},
                         {"results_hash", results_hash(r.report)},
                         {"build", build_json()},
                         {"machine", machine_json(r.options.threads)}};
  return manifest.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string results_hash(const RunReport& report) {
  std::string bytes = std::to_string(report.steps) + " " + std::to_string(report.frames) + " ";
  auto append = [&](const double* data, Eigen::Index size) {
    bytes.append(reinterpret_cast<const char*>(data), static_cast<std::size_t>(size) * sizeof(double));
  };
  append(&report.state.t, 1);
  append(report.state.q.data(), report.state.q.size());
  append(report.state.v.data(), report.state.v.size());
  return text_hash(bytes);
}

Rerun read_rerun(const SimulateOptions& given) {
  const Json manifest = Json::parse(read_file(given.rerun), nullptr, false);
  if (manifest.is_discarded() || !manifest.is_object()) fail_rerun(given.rerun, "no JSON object");
  try {
    if (manifest.at("program") != "simulate") fail_rerun(given.rerun, "a manifest of another program");
    Rerun rerun{given, {}, manifest.at("results_hash")};
    const Json& scene = manifest.at("scene");
    rerun.file = scene.at("file").get<std::string>();
    rerun.options.scene = given.rerun.parent_path() / scene.at("copy").get<std::string>();
    rerun.options.changes = scene.at("changes").get<std::vector<std::string>>();
    rerun.options.preset = scene.at("preset");
    rerun.options.allow_outside = scene.at("allow_outside");
    rerun.options.threads = manifest.at("options").at("threads");
    if (given.out.empty())
      rerun.options.out = std::filesystem::path("results/scenes") / (rerun.file.stem().string() + "_rerun");
    if (text_hash(read_file(rerun.options.scene)) != scene.at("hash").get<std::string>())
      fail_rerun(given.rerun, "the scene beside it has another hash");
    return rerun;
  } catch (const nlohmann::json::exception& error) {
    fail_rerun(given.rerun, error.what());
  }
}

}  // namespace feder::experiments
