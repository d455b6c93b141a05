// Somebody else's program: a scene of the catalogue, one built by hand, and an error, through the installed
// package.
#include <cstdio>
#include <exception>
#include <limits>

#include "engine/check.h"
#include "models/catalog.h"
#include "solvers/ida_reference.h"
#include "solvers/integrators.h"
#include "solvers/simulate.h"

namespace {

constexpr double kEndTime = 1.0;

double final_position(const char* method) {
  feder::Model model = feder::make_model("oscillator");
  feder::Integrator integrator = feder::make_integrator(method, model.system);
  feder::History history;
  feder::RunOptions options;
  options.dt = 0.01;
  options.end_time = kEndTime;
  const feder::RunResult run = feder::simulate(model.system, integrator, model.state, history, options);
  if (!run.status.ok()) std::printf("%s: %s\n", method, run.status.reason.c_str());
  return model.state.q[3] - 1.0;
}

void hang_on_a_rod() {
  feder::SystemBuilder builder;
  builder.set_gravity({0.0, -9.81, 0.0});
  const feder::Anchor hook = builder.add_world_point({0.0, 0.0, 0.0});
  const feder::Anchor load = builder.add_particle(2.0, {0.0, -1.0, 0.0});
  const int rod = builder.add_distance(hook, load, {std::numeric_limits<double>::infinity()}, 1.0);
  auto [system, state] = builder.build();
  feder::Integrator integrator = feder::make_integrator("implicit_euler_notes", system);
  feder::History history;
  feder::RunOptions options;
  options.dt = 0.01;
  options.end_time = kEndTime;
  const feder::RunResult run = feder::simulate(system, integrator, state, history, options);
  if (!run.status.ok()) {
    std::printf("rod: %s\n", run.status.reason.c_str());
    return;
  }
  std::printf("rod_multiplier %.17g\n", history.lambda[system.row_of_id[rod]]);
  std::printf("rod_length %.17g\n", state.q.segment<3>(3 * load.node).norm());
}

void refuse_a_mass() {
  feder::SystemBuilder builder;
  try {
    builder.add_particle(-1.0, {0.0, 0.0, 0.0});
    std::printf("refused_mass 0\n");
  } catch (const feder::InputError& error) {
    std::printf("refused: %s\n", error.what());
    std::printf("refused_mass 1\n");
  }
}

}  // namespace

int main() {
  try {
    for (const char* method : {"implicit_euler_notes", "rk4", "leapfrog"})
      std::printf("%s %.17g\n", method, final_position(method));
    const feder::Model model = feder::make_model("oscillator");
    std::printf("ida %.17g\n", feder::ida_solve(model.system, model.state, kEndTime).state.q[3] - 1.0);
    std::printf("catalog_exact %.17g\n", model.exact(kEndTime).q[3] - 1.0);
    hang_on_a_rod();
    refuse_a_mass();
  } catch (const std::exception& error) {
    std::printf("%s\n", error.what());
    return 1;
  }
  return 0;
}
