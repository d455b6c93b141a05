// Which poses does an arm reach, and what does it take to find joints for them?
// Targets: random poses within the limits, solved from the middle of the limits; and the same moved out of
// the reach of the links, where the closest pose is looked for. Workspace: where the tool of two links and of
// a PUMA gets, and how well it moves there.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/check.h"
#include "experiments/support/draws.h"
#include "experiments/support/experiment.h"
#include "experiments/support/timing.h"
#include "models/robot/arms.h"
#include "solvers/inverse_kinematics.h"

namespace feder::experiments {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kDrawn = 4000;       // points of a workspace that a chart shows
constexpr double kFarthest = 2.0;  // targets out of reach, of the reach

const ExperimentInfo kInfo{
    .name = "robot_reach",
    .question = "Which poses does an arm reach, and what does it take to find joints for them?",
    .not_modelled = "Collisions of the arm with itself; a way from where the joints are.",
    .settings = {{"targets", Kind::kInteger, "500", "100000", "random poses per arm"},
                 {"far_targets", Kind::kInteger, "50", "1000", "poses out of reach per arm"},
                 {"samples", Kind::kInteger, "4000", "100000", "joints drawn for the workspace"}},
    .columns = {"study", "scene", "status", "targets", "reached", "unreachable", "error", "iterations",
                "iterations_90", "iterations_most", "starts_most", "seconds", "seconds_90", "scene_length"},
    .cases = {"targets: every arm, within reach and out of it", "workspace: planar_2r, puma560"}};

// ---- Targets

double at_fraction(std::vector<double> values, double fraction) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(fraction * static_cast<double>(values.size() - 1))];
}

// What solving many targets came to.
struct Tally {
  std::int64_t targets = 0, reached = 0, unreachable = 0, most_starts = 0;
  double worst = 0.0;  // error of those reached
  std::vector<double> iterations = {}, seconds = {};

  void solve(InverseKinematics& solver, const Pose& target) {
    const Stopwatch watch;
    const InverseKinematicsResult result = solver.solve(target);
    seconds.push_back(watch.seconds());
    iterations.push_back(result.iterations);
    most_starts = std::max<std::int64_t>(most_starts, result.starts);
    ++targets;
    unreachable += result.outcome == PoseOutcome::kUnreachable;
    if (result.outcome != PoseOutcome::kReached) return;
    ++reached;
    worst = std::max({worst, result.error.place, result.error.angle});
  }
};

void add_row(Context& context, const char* study, const KinematicMap& map, const Tally& tally) {
  if (tally.targets == 0) return;
  context.table.add({{"study", study},
                     {"scene", map.name},
                     {"status", "ok"},
                     {"targets", tally.targets},
                     {"reached", tally.reached},
                     {"unreachable", tally.unreachable},
                     {"error", tally.reached > 0 ? Cell(tally.worst) : Cell()},
                     {"iterations", median(tally.iterations)},
                     {"iterations_90", at_fraction(tally.iterations, 0.9)},
                     {"iterations_most", at_fraction(tally.iterations, 1.0)},
                     {"starts_most", tally.most_starts},
                     {"seconds", median(tally.seconds)},
                     {"seconds_90", at_fraction(tally.seconds, 0.9)},
                     {"scene_length", map.reach.greatest}});
}

void study_targets(Context& context, const Arm& arm) {
  InverseKinematics solver(kinematic_map(arm));
  const Ring& reach = solver.map().reach;
  Draws draws(context.seed);
  Tally within, beyond;
  for (std::int64_t i = 0; i < context.settings.integer("targets") && !context.interrupted(); ++i)
    within.solve(solver, tool_pose(arm, draws.joints(solver.map())));
  for (std::int64_t i = 0; i < context.settings.integer("far_targets") && !context.interrupted(); ++i) {
    Pose target = tool_pose(arm, draws.joints(solver.map()));
    const Vector3d out = (target.position - reach.centre).normalized();
    target.position = reach.centre + draws.uniform(1.01, kFarthest) * reach.greatest * out;
    beyond.solve(solver, target);
  }
  add_row(context, "within", solver.map(), within);
  add_row(context, "beyond", solver.map(), beyond);
  context.note(fmt::format(
      "{}: {} of {} poses of its own reached within the limits, to {:.0e} m and rad; of {} beyond "
      "its reach {} found unreachable.",
      arm.name, within.reached, within.targets, within.worst, beyond.targets, beyond.unreachable));
  context.progress.advance(arm.name + " targets");
}

// ---- Workspace

// Where the tool gets, in thirds of its manipulability; x and y of a planar arm, of others distance from the
// first axis and height.
void add_workspace(Context& context, const Arm& arm, Panel& panel) {
  const KinematicMap map = kinematic_map(arm);
  struct Sample {
    double x, y, manipulability;
  };
  std::vector<Sample> samples;
  Draws draws(context.seed);
  Pose tool;
  ToolJacobian J;
  double farthest = 0.0;
  for (std::int64_t i = 0; i < context.settings.integer("samples") && !context.interrupted(); ++i) {
    map.evaluate(draws.joints(map).data(), tool, J);
    const Vector3d& p = tool.position;
    const bool planar = arm.task.size() == 2;
    samples.push_back({planar ? p.x() : std::hypot(p.x(), p.y()), planar ? p.y() : p.z(),
                       manipulability(Eigen::MatrixXd(J)(arm.task, Eigen::all))});
    farthest = std::max(farthest, (p - map.reach.centre).norm());
  }
  double most = 0.0;
  for (const Sample& sample : samples) most = std::max(most, sample.manipulability);
  constexpr const char* kThirds[] = {"lowest third of manipulability", "middle third", "highest third"};
  for (int third = 0; third < 3; ++third) {
    Series series{.label = kThirds[third], .look = third, .line = false, .marker_size = 0.3};
    for (std::size_t i = 0; i < samples.size() && i < kDrawn; ++i)
      if (std::min(2, static_cast<int>(3.0 * samples[i].manipulability / most)) == third)
        series.add(samples[i].x, samples[i].y);
    panel.series.push_back(std::move(series));
  }
  context.note(fmt::format("{}: farthest sample {:.4f} m from the first joint, bound by its links {:.4f} m.",
                           arm.name, farthest, map.reach.greatest));
  context.progress.advance(arm.name + " workspace");
}

void add_workspaces(Context& context) {
  Chart chart{
      .name = "robot_reach",
      .title = "Where the tool gets",
      .caption =
          "Tool places for random joints, by thirds of the largest manipulability; circles are where two "
          "links are stretched or folded. The PUMA's places are turned about its first axis into a "
          "plane."};
  const Arm two = planar_2r();
  Panel ring{.title = "two links of 1 m and 0.6 m", .x = {"x [m]"}, .y = {"y [m]"}, .equal = true};
  add_workspace(context, two, ring);
  for (const double r : {reach_of(two).least, reach_of(two).greatest}) {
    Series circle{.label = "singular poses", .theory = true};
    for (int i = 0; i <= 360; ++i) circle.add(r * std::cos(i * kPi / 180.0), r * std::sin(i * kPi / 180.0));
    ring.series.push_back(std::move(circle));
  }
  Panel slice{.title = "puma560",
              .x = {"distance from the first axis [m]", false, 0.0},
              .y = {"height [m]"},
              .equal = true};
  add_workspace(context, puma560(), slice);
  chart.panels = {std::move(ring), std::move(slice)};
  context.add_chart(std::move(chart));
}

// ---- The experiment

void body(Context& context) {
  for (const char* key : {"targets", "far_targets", "samples"})
    if (context.settings.integer(key) < 1)
      fail_input(fmt::format("setting '{}'", key), "value",
                 static_cast<double>(context.settings.integer(key)), "", "at least 1");
  context.progress.start(static_cast<long>(arm_list().size()) + 2);
  for (const ArmInfo& info : arm_list()) study_targets(context, info.make());
  add_workspaces(context);
}

}  // namespace
}  // namespace feder::experiments

int main(int argc, char** argv) {
  return feder::experiments::run_experiment(feder::experiments::kInfo, argc, argv, feder::experiments::body);
}
