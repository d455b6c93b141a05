// What contacts cost beside the step's own linear solve: a cloth that lies down on a ball, by friction and by
// how well the contact law is to hold. Per step (finding contacts + everything the law takes) / (factor +
// solve), medians and quartiles over the steps with contacts; one thread, all in one run.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "models/catalog.h"
#include "solvers/simulate.h"
#include "solvers/threads.h"

namespace feder {
namespace {

constexpr double kEndTime = 0.15;  // the cloth touches at 0.064 s and lies on the ball's top then [s]

double quantile(std::vector<double> x, double share) {
  const auto at = x.begin() + static_cast<long>(share * static_cast<double>(x.size() - 1));
  std::nth_element(x.begin(), at, x.end());
  return *at;
}

void measure(const std::string& spec, double dt, double tolerance) {
  Model model = make_model(spec);
  Integrator integrator = make_integrator("implicit_euler_notes", model.system);
  History history;
  std::vector<double> ratio;
  ContactCounts last;
  long most = 0;
  const auto observe = [&](const State&, const History&) {
    ContactStep& contacts = *std::get<ImplicitEulerNotes>(integrator).contacts();
    contacts.options().held_tolerance = tolerance;
    const ContactCounts& now = contacts.counts();
    if (now.contacts > last.contacts)
      ratio.push_back((now.seconds_find - last.seconds_find + now.seconds_solve - last.seconds_solve) /
                      (now.seconds_own - last.seconds_own));
    most = std::max(most, now.contacts - last.contacts);
    last = now;
    return true;
  };
  const RunResult run = simulate(model.system, integrator, model.state, history,
                                 {.dt = dt, .end_time = kEndTime, .observer = observe});
  if (ratio.empty()) ratio.push_back(0.0);
  const double steps = std::max(1.0, static_cast<double>(last.steps));
  std::printf("%-52s %7.0e  %-14s %5ld  %7.2f [%5.2f %5.2f]  %6.2f %6.2f  %7.1f\n", spec.c_str(), tolerance,
              to_string(run.status.code), most, quantile(ratio, 0.5), quantile(ratio, 0.25),
              quantile(ratio, 0.75), static_cast<double>(last.passes) / steps,
              static_cast<double>(last.factorizations) / steps, run.seconds);
  (void)std::fflush(stdout);
}

int run(const char* size) {
  std::printf("%-52s %7s  %-14s %5s  %-21s  %6s %6s  %7s\n", "scene", "law to", "status", "most",
              "contacts / own solve", "passes", "refact", "s");
  for (const char* friction : {"0", "0.3"})
    for (const double tolerance : {1e-4, 1e-6})
      measure(std::string("cloth_drop:n=") + size + ",friction=" + friction, 1e-3, tolerance);
  return 0;
}

}  // namespace
}  // namespace feder

int main(int argc, char** argv) {
  feder::restart_with_better_blas(argv);
  return feder::run(argc > 1 ? argv[1] : "100");
}
