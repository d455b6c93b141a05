// Feder beside other engines on the same mechanisms: one run, one thread, steps taken in turn so that a busy
// machine hits all alike. Whole steps, wall time; peers without collision detection. Peers are Debian's
// builds (double precision, no vector extensions). They answer other questions: Bullet's chain steps in joint
// coordinates with explicit forces, ODE stops after 20 sweeps, MuJoCo's joints are soft by design.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "models/catalog.h"
#include "solvers/stopwatch.h"
#include "solvers/threads.h"
#include "tests/bench/oracle_simulator.h"

namespace feder {
namespace {

constexpr const char* kChainMethod = "implicit_euler_notes";
constexpr const char* kChainRoute = "auto";
constexpr const char* kBridgeMethod = "implicit_euler_newton";
constexpr const char* kBridgeRoute = "auto";
constexpr double kFrame = 1.0 / 60.0;  // [s]
constexpr double kLink = 0.2;          // of the bridges [m]
constexpr double kBridgeTime = 1.0;    // simulated [s]
constexpr double kMostSeconds = 60.0;  // wall time of one engine on one bridge
const std::string kNothing = "-";

struct Quartiles {
  double low, median, high;
};

Quartiles quartiles(std::vector<double> x) {
  std::sort(x.begin(), x.end());
  return {x[x.size() / 4], x[x.size() / 2], x[3 * x.size() / 4]};
}

// A simulator and what it took, one entry per turn.
struct Contender {
  SimulatorPtr simulator;
  std::vector<double> seconds = {};  // per step
  Status status = {};
  double spent = 0.0;
  long steps = 0;

  bool running() const { return status.ok() && spent < kMostSeconds; }
  void take(int count, double dt) {
    double total = 0.0;
    {
      const Stopwatch watch(total);
      for (int k = 0; k < count && status.ok(); ++k) status = simulator->step(dt);
    }
    spent += total;
    if (!status.ok()) return;
    seconds.push_back(total / count);
    steps += count;
  }
};

// Ratio of times, peer against Feder, of turns both took.
std::string ratio_text(const Contender& peer, const Contender& own) {
  std::vector<double> ratio;
  for (std::size_t i = 0; i < std::min(peer.seconds.size(), own.seconds.size()); ++i)
    ratio.push_back(peer.seconds[i] / own.seconds[i]);
  if (ratio.empty()) return kNothing;
  const Quartiles q = quartiles(ratio);
  return fmt::format("{:.2f} [{:.2f} {:.2f}]", q.median, q.low, q.high);
}

std::string milliseconds(const Contender& contender) {
  if (contender.seconds.empty()) return kNothing;
  return fmt::format("{:.3f}", 1e3 * quartiles(contender.seconds).median);
}

double widest_gap(const Model& model, const Simulator& simulator) {
  double widest = 0.0;
  for (const BallRow& joint : joints_of(model.system))
    widest =
        std::max(widest, (place_of(model, joint.b, simulator) - place_of(model, joint.a, simulator)).norm());
  return widest;
}

#ifdef FEDER_ORACLE_BULLET
void compare_motion(double dt) {
  const Model model = make_model("S3c(100)");
  const SimulatorPtr own = make_feder(model, kChainMethod, kChainRoute), peer = make_bullet(model);
  Status status;
  for (long k = std::lround(0.1 / dt); k > 0 && status.ok(); --k) {
    status = own->step(dt);
    if (status.ok()) status = peer->step(dt);
  }
  if (!status.ok()) {
    std::printf("%s\n", status.reason.c_str());
    return;
  }
  double apart = 0.0;
  for (int i = 0; i < std::ssize(model.system.bodies); ++i)
    apart = std::max(apart, (own->pose(i).centre - peer->pose(i).centre).norm());
  const Anchor tip{.body = 99, .point = {0.05, 0.0, 0.0}};
  const Vector3d a = place_of(model, tip, *own), b = place_of(model, tip, *peer);
  std::printf("dt = %g s: tip %-6s (%.9f, %.9f, %.9f) m\n%*stip %-6s (%.9f, %.9f, %.9f) m\n", dt, own->name(),
              a.x(), a.y(), a.z(), static_cast<int>(fmt::format("dt = {:g} s: ", dt).size()), "",
              peer->name(), b.x(), b.y(), b.z());
  std::printf("  tips %.2e m apart, any centre at most %.2e m\n", (a - b).norm(), apart);
}

// btMultiBody keeps (3 links)^2 numbers, of which it uses the blocks along the diagonal.
bool bullet_fits(int links) {
  const double wanted = 72.0 * links * links;
  return wanted <
         0.8 * static_cast<double>(sysconf(_SC_AVPHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

void race_chain(int links, double dt, int turns, int steps) {
  const std::string scene = fmt::format("S3c({})", links);
  if (!bullet_fits(links)) {
    std::printf("%-10s  not run: Bullet needs %.1f GB\n", scene.c_str(), 72e-9 * links * links);
    return;
  }
  const Model model = make_model(scene);
  Contender own{make_feder(model, kChainMethod, kChainRoute)}, peer{make_bullet(model)};
  for (int turn = 0; turn < turns && own.running() && peer.running(); ++turn) {
    own.take(steps, dt);
    peer.take(steps, dt);
  }
  std::printf("%-10s  %8.6f %10s %10s  %-22s %s%s\n", scene.c_str(), dt, milliseconds(own).c_str(),
              milliseconds(peer).c_str(), ratio_text(peer, own).c_str(), own.status.reason.c_str(),
              peer.status.reason.c_str());
  std::fflush(stdout);
}

void race_chains() {
  std::printf("Chain of boxes falling from rest, Feder %s, route %s, against one btMultiBody: at t = 0.1 s\n",
              kChainMethod, kChainRoute);
  compare_motion(1e-3);
  compare_motion(1.25e-4);
  std::printf("\n%-10s  %8s %10s %10s  %s\n", "scene", "dt s", "Feder ms", "Bullet ms",
              "Bullet / Feder [quartiles]");
  for (const double dt : {1e-3, kFrame}) {
    race_chain(100, dt, 25, 8);
    race_chain(1000, dt, 25, 4);
    race_chain(10000, dt, 20, 2);
  }
}
#endif

void race_bridge(const char* scene) {
  const Model model = make_model(scene);
  std::vector<Contender> contenders;
  contenders.push_back({make_feder(model, kBridgeMethod, kBridgeRoute)});
#ifdef FEDER_ORACLE_ODE
  contenders.push_back({make_ode(model)});
#endif
#ifdef FEDER_ORACLE_MUJOCO
  contenders.push_back({make_mujoco(model)});
#endif
  for (long k = std::lround(kBridgeTime / kFrame); k > 0; --k)
    for (Contender& contender : contenders)
      if (contender.running()) contender.take(1, kFrame);
  for (const Contender& c : contenders) {
    const std::string gap =
        c.steps == 0 ? kNothing : fmt::format("{:.2e}", widest_gap(model, *c.simulator) / kLink);
    std::printf("%-10s  %-14s %10s  %-24s %9s %7.3f  %s\n", scene, c.simulator->name(),
                milliseconds(c).c_str(), ratio_text(c, contenders[0]).c_str(), gap.c_str(),
                static_cast<double>(c.steps) * kFrame, c.status.reason.c_str());
  }
  std::fflush(stdout);
}

void race_bridges() {
  std::printf("\nBridges of plates, dt = 1/60 s, Feder %s, route %s; 1 s simulated or %g s of wall time\n",
              kBridgeMethod, kBridgeRoute, kMostSeconds);
  std::printf("%-10s  %-14s %10s  %-24s %9s %7s\n", "scene", "engine", "ms / step", "to Feder [quartiles]",
              "gap/link", "at t s");
  race_bridge("S3b(30,10)");
  race_bridge("S3b(40,30)");
}

void run() {
  set_threads(1);
  std::printf("BLAS: %s\n\n", blas_name().c_str());
#ifdef FEDER_ORACLE_BULLET
  race_chains();
#endif
  race_bridges();
}

}  // namespace
}  // namespace feder

int main(int, char** argv) {
  feder::restart_with_better_blas(argv);
  feder::run();
}
