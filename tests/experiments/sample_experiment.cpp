// The smallest complete experiment: stands for all of them where the contract itself is tested.

#include <chrono>
#include <cmath>
#include <thread>

#include "engine/check.h"
#include "experiments/support/experiment.h"

namespace {

using namespace feder::experiments;

const ExperimentInfo kInfo{
    .name = "sample_experiment",
    .question = "Does the contract hold?",
    .not_modelled = "Everything <else>.",
    .settings = {{"dt", Kind::kNumbers, "1e-3:1e-1:5", "1e-4:1e-1:20", "time steps, s"},
                 {"method", Kind::kText, "good", "good", "what to do", {"good", "bad", "slow", "throw"}}},
    .columns = {"scene", "integrator", "dt", "status", "reason", "error", "reference_error", "seconds"},
    .cases = {"chain x good"}};

void add_run(Context& context, double dt) {
  if (dt > 0.05) {
    context.table.add({{"scene", "chain"}, {"integrator", "good"}, {"dt", dt}, {"status", "diverged"}});
    return;
  }
  context.table.add({{"scene", "chain"},
                     {"integrator", "good"},
                     {"dt", dt},
                     {"status", "ok"},
                     {"error", dt * dt},
                     {"reference_error", 2e-6},
                     {"seconds", 1e-3 / dt}});
}

void body(Context& context) {
  const std::string& method = context.settings.text("method");
  const std::vector<double> steps = context.settings.numbers("dt");
  context.progress.start(static_cast<long>(steps.size()));
  for (const double dt : steps) {
    if (context.interrupted()) break;
    if (dt <= 0) throw feder::InputError("setting 'dt': expected positive time steps");
    add_run(context, dt);
    if (method == "slow") context.log("started");
    while (method == "slow" && !context.interrupted())
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    context.progress.advance("chain");
  }
  if (method == "bad")
    context.fail(feder::Status::failure(feder::StatusCode::kNotConverged, "the judge gave up"));
  if (method == "throw") throw feder::MisuseError("a broken precondition");
  const Panel panel{.title = "sample",
                    .x = {"time step dt [s]", true},
                    .y = {"error [m]", true},
                    .series = series_by(context.table, "integrator", "dt", "error"),
                    .slopes = {{2}},
                    .judge_error = 2e-6};
  context.add_chart({.name = "sample", .title = "Sample", .caption = "Slope two.", .panels = {panel}});
  context.note("The slope is two.");
}

}  // namespace

int main(int argc, char** argv) {
  return run_experiment(kInfo, argc, argv, body);
}
