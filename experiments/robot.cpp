// What do singular poses cost an arm that follows a path?
// Passages: two equal links past their base, where they fold; a PUMA's wrist past the pose with its axes in
// line; the two links with a third one; at several distances from the singular place. Lines: random straight
// lines of the tool, without turning it, from random joints.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/check.h"
#include "experiments/support/draws.h"
#include "experiments/support/experiment.h"
#include "experiments/support/timing.h"
#include "models/robot/arms.h"
#include "solvers/follow_path.h"
#include "solvers/inverse_kinematics.h"
#include "solvers/two_link.h"

namespace feder::experiments {
namespace {

constexpr double kPi = std::numbers::pi;

const std::string kTwo = "two links", kWrist = "PUMA wrist", kThree = "three links";

struct Method {
  PathMethod method;
  const char* name;
};
constexpr Method kMethods[] = {{PathMethod::kPseudoInverse, "pseudo_inverse"},
                               {PathMethod::kDamped, "damped"},
                               {PathMethod::kNullSpace, "null_space"}};

const ExperimentInfo kInfo{
    .name = "robot",
    .question = "What do singular poses cost an arm that follows a path: speed of its joints, or error?",
    .not_modelled = "Inertia, torque limits, collisions of the arm with itself.",
    .settings = {{"offsets", Kind::kNumbers, "1e-3:1:7", "1e-5:1:21",
                  "distances from the singular place, m or rad"},
                 {"shown_offset", Kind::kNumber, "0.01", "0.01",
                  "the passage that is shown along its path, m or rad"},
                 {"lines", Kind::kInteger, "40", "1000", "random lines per arm"},
                 {"line_length", Kind::kNumber, "0.3", "0.3", "of a line, of the arm's reach"},
                 {"line_arms", Kind::kTexts, "planar_nr,puma560,ur5,panda",
                  "planar_nr,puma560,stanford,ur5,panda", "arms that follow lines"},
                 {"pieces", Kind::kInteger, "400", "2000", "of a path, at least"},
                 {"threshold", Kind::kNumber, "0.1", "0.1", "of the smallest singular value for damping, m"},
                 {"damping", Kind::kNumber, "1e-2", "1e-2", "gamma at a singular pose, m^2"}},
    .columns = {"study", "scene", "method", "offset", "line", "status", "reason", "steps", "halvings",
                "error", "end_error", "speed", "smallest_singular_value", "seconds", "scene_length"},
    .cases = {"passages: two links, PUMA wrist, three links x methods x offsets",
              "lines: line_arms x methods x lines"}};

// ---- Passages

// A path, and joints at its start.
struct Passage {
  std::string scene;
  Arm arm;
  double scene_length;
  std::function<Pose(double s)> path;
  VectorXd start;
};

// Two links of 1 m: the tool along a line at distance `offset` from the base, where alone they can fold.
Passage past_the_base(double offset) {
  Passage p{kTwo, planar_2r(1.0, 1.0), 2.0, {}, VectorXd(2)};
  for (DhRow& row : p.arm.rows) row.least = -4.0 * kPi, row.greatest = 4.0 * kPi;
  p.path = [=](double s) { return Pose{Matrix3d::Identity(), {1.2 - 2.4 * s, offset, 0.0}}; };
  const TwoLinkAngles q = two_link_angles(1.0, 1.0, 1.2, offset)->front();
  p.start << q.A, q.B;
  return p;
}

// A PUMA that turns its hand over, its last axis at the angle `offset` past the fourth one.
Passage past_the_wrist(double offset) {
  Passage p{kWrist, puma560(), 0.9, {}, VectorXd{{0.3, 0.6, -0.4, 0.2, 0.6, 0.1}}};
  for (DhRow& row : p.arm.rows) row.least = -4.0 * kPi, row.greatest = 4.0 * kPi;
  const auto at = [arm = p.arm, start = p.start](double fifth) {
    VectorXd q = start;
    q[4] = fifth;
    return frames(arm, q);
  };
  // away from the plane in which the fifth joint turns the hand
  const std::vector<Pose> in_line = at(0.0);
  const Vector3d axis = in_line[4].rotation.col(2).cross(in_line[6].rotation.col(2)).normalized();
  const Matrix3d tilt = Eigen::AngleAxisd(offset, axis).toRotationMatrix();
  p.path = [at, tilt](double s) {
    const Pose tool = at(0.6 - 1.2 * s).back();
    return Pose{tilt * tool.rotation, tool.position};
  };
  InverseKinematics solver(kinematic_map(p.arm));
  p.start = solver.solve(p.path(0.0), p.start).q;
  return p;
}

// The two links and a third of 0.2 m on the same line: a joint to spare.
Passage with_a_third_link(double offset) {
  Passage p = past_the_base(offset);
  p.scene = kThree, p.arm.rows.push_back(p.arm.rows.back()), p.arm.rows.back().a = 0.2;
  const VectorXd near{{p.start[0], p.start[1], 0.0}};
  p.start = InverseKinematics(kinematic_map(p.arm)).solve(p.path(0.0), near).q;
  return p;
}

PathOptions path_options(const Context& context, PathMethod method, double length) {
  PathOptions o;
  o.method = method;
  o.pieces = static_cast<int>(context.settings.integer("pieces"));
  o.length = length;
  o.damping = {.threshold = context.settings.number("threshold"), .most = context.settings.number("damping")};
  return o;
}

struct Followed {
  PathResult result;
  double error = 0.0, speed = 0.0, smallest = 0.0, seconds = 0.0;
};

// Without joints to spare there is no null space.
bool applies(const Method& m, const Arm& arm) {
  return m.method != PathMethod::kNullSpace || arm.joints() > std::ssize(arm.task);
}

// Error in metres, a radian weighing `length`.
double error_of(const PathPoint& p, double length) {
  return std::hypot(p.error.place, length * p.error.angle);
}

Followed follow(const KinematicMap& map, const Passage& p, const PathOptions& options) {
  Followed out;
  const Stopwatch watch;
  out.result = follow_path(map, p.path, p.start, options);
  out.seconds = watch.seconds();
  out.smallest = std::numeric_limits<double>::infinity();
  for (const PathPoint& point : out.result.points) {
    out.error = std::max(out.error, error_of(point, options.length));
    out.speed = std::max(out.speed, point.speed);
    out.smallest = std::min(out.smallest, point.smallest);
  }
  return out;
}

void add_row(Context& context, const char* study, const Passage& p, const char* method, const Followed& f,
             const PathOptions& options, Cell offset, Cell line) {
  context.table.add({{"study", study},
                     {"scene", p.scene},
                     {"method", method},
                     {"offset", offset},
                     {"line", line},
                     {"status", to_string(f.result.status.code)},
                     {"reason", f.result.status.reason},
                     {"steps", static_cast<std::int64_t>(f.result.points.size()) - 1},
                     {"halvings", f.result.halvings},
                     {"error", f.error},
                     {"end_error", error_of(f.result.points.back(), options.length)},
                     {"speed", f.speed},
                     {"smallest_singular_value", f.smallest},
                     {"seconds", f.seconds},
                     {"scene_length", p.scene_length}});
}

void study_passages(Context& context, const std::function<Passage(double)>& make) {
  for (const double offset : context.settings.numbers("offsets")) {
    const Passage passage = make(offset);
    const KinematicMap map = kinematic_map(passage.arm);
    for (const Method& m : kMethods) {
      if (context.interrupted()) return;
      if (!applies(m, passage.arm)) continue;
      const PathOptions options = path_options(context, m.method, 1.0);
      add_row(context, "passage", passage, m.name, follow(map, passage, options), options, offset, {});
    }
    context.progress.advance(fmt::format("{} past {:.1e}", passage.scene, offset));
  }
}

// One passage along its path: error and speed.
void add_along(Context& context, const Passage& p, Chart& chart) {
  const KinematicMap map = kinematic_map(p.arm);
  Panel error{.title = p.scene + ": error", .x = {"along the path [1]"}, .y = {"error [m]", true, 1e-12}},
      speed{.title = p.scene + ": speed", .x = {"along the path [1]"}, .y = {"joint speed [rad/s]", true}};
  for (std::size_t look = 0; look < std::size(kMethods); ++look) {
    if (!applies(kMethods[look], p.arm)) continue;
    const PathOptions options = path_options(context, kMethods[look].method, 1.0);
    const Series empty{.label = kMethods[look].name, .look = look, .markers = false};
    Series e = empty, v = empty;
    for (const PathPoint& point : follow(map, p, options).result.points) {
      if (point.s == 0.0) continue;
      e.add(point.s, std::max(error_of(point, 1.0), 1e-12));
      v.add(point.s, point.speed);
    }
    error.series.push_back(std::move(e));
    speed.series.push_back(std::move(v));
  }
  chart.panels.push_back(std::move(error));
  chart.panels.push_back(std::move(speed));
}

// Rows of one study, scene and method.
std::vector<std::size_t> rows_of(const Table& table, const char* study, const std::string& scene,
                                 const char* method) {
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < table.rows(); ++row)
    if (table.at(row, "study").text() == study && table.at(row, "scene").text() == scene &&
        table.at(row, "method").text() == method)
      rows.push_back(row);
  return rows;
}

Chart offsets_chart(const Table& table) {
  Chart chart{
      .name = "robot_distance",
      .title = "What is left to choose: speed or error",
      .caption =
          "Largest joint speed and error of a passage over its distance from the singular place. Under J^+ "
          "speed grows as one over the distance; damped it is bounded, for an error (a radian counts as a "
          "metre), and the arm may come out on another branch; three links need not fold."};
  for (const std::string& scene : {kTwo, kWrist, kThree})
    for (const char* column : {"speed", "error"}) {
      const bool fast = std::string(column) == "speed";
      Panel panel{.title = scene + ": " + column,
                  .x = {scene == kWrist ? "distance [rad]" : "distance [m]", true},
                  .y = {fast ? "largest joint speed [rad/s]" : "largest error [m]", true}};
      for (std::size_t look = 0; look < std::size(kMethods); ++look) {
        Series series{.label = kMethods[look].name, .look = look};
        for (const std::size_t row : rows_of(table, "passage", scene, kMethods[look].name)) {
          const double offset = table.at(row, "offset").number();
          if (table.at(row, "status").text() == "ok")
            series.add(offset, table.at(row, column).number());
          else
            series.failed_x.push_back(offset);
        }
        if (!series.x.empty() || !series.failed_x.empty()) panel.series.push_back(std::move(series));
      }
      // under the curve of the pseudo-inverse, whose speed is between 1.7 and 2.4 over the distance
      if (fast && scene != kThree) panel.slopes = {{.order = -1.0, .x = 0.04, .y = 0.9 / 0.04}};
      chart.panels.push_back(std::move(panel));
    }
  return chart;
}

// ---- Lines

Vector3d direction(Draws& draws, bool planar) {
  const double z = planar ? 0.0 : draws.uniform(-1.0, 1.0), turn = draws.uniform(-kPi, kPi),
               r = std::sqrt(1.0 - z * z);
  return {r * std::cos(turn), r * std::sin(turn), z};
}

void study_lines(Context& context, const Arm& arm) {
  const KinematicMap map = kinematic_map(arm);
  const double length = map.reach.greatest / 3.0,
               way = context.settings.number("line_length") * map.reach.greatest;
  Draws draws(context.seed);
  for (std::int64_t line = 0; line < context.settings.integer("lines"); ++line) {
    Passage p{arm.name, arm, map.reach.greatest, {}, draws.joints(map)};
    const Pose from = tool_pose(arm, p.start);
    const Vector3d to = way * direction(draws, arm.task.size() == 2);
    p.path = [=](double s) { return Pose{from.rotation, from.position + s * to}; };
    for (const Method& m : kMethods) {
      if (context.interrupted()) return;
      if (!applies(m, arm)) continue;
      const PathOptions options = path_options(context, m.method, length);
      add_row(context, "line", p, m.name, follow(map, p, options), options, {}, line);
    }
    context.progress.advance(fmt::format("{} line {}", arm.name, line));
  }
}

Chart lines_chart(Context& context) {
  Chart chart{
      .name = "robot_lines",
      .title = "Random straight lines",
      .caption =
          "Share of the lines that were followed to the end, to 1e-6 m throughout, with a largest "
          "joint speed of at most that on the axis; the others run into a limit, out of reach or, damped, "
          "too far off."};
  const Table& table = context.table;
  const auto count = static_cast<double>(context.settings.integer("lines"));
  for (const std::string& arm : context.settings.texts("line_arms")) {
    Panel panel{.title = arm,
                .x = {"largest joint speed [rad/s]", true},
                .y = {"share of the lines [1]", false, 0.0, 1.0}};
    for (std::size_t look = 0; look < std::size(kMethods); ++look) {
      std::vector<double> speeds;
      for (const std::size_t row : rows_of(table, "line", arm, kMethods[look].name))
        if (table.at(row, "status").text() == "ok" && table.at(row, "error").number() <= 1e-6)
          speeds.push_back(table.at(row, "speed").number());
      if (speeds.empty()) continue;
      std::sort(speeds.begin(), speeds.end());
      Series series{.label = kMethods[look].name, .look = look, .markers = false};
      for (std::size_t i = 0; i < speeds.size(); ++i)
        series.add(speeds[i], static_cast<double>(i + 1) / count);
      context.note(
          fmt::format("{}, {}: {} of {:.0f} lines followed to 1e-6 m, median {:.2g}, at most {:.3g} rad/s.",
                      arm, kMethods[look].name, speeds.size(), count, median(speeds), speeds.back()));
      panel.series.push_back(std::move(series));
    }
    chart.panels.push_back(std::move(panel));
  }
  return chart;
}

// ---- The experiment

void check(const Settings& settings) {
  for (const char* key : {"shown_offset", "line_length", "threshold", "damping"})
    require_positive(fmt::format("setting '{}'", key), "value", settings.number(key), "");
  for (const double offset : settings.numbers("offsets")) {
    require_positive("setting 'offsets'", "value", offset, "m");
    if (offset > 1.4)
      fail_input("setting 'offsets'", "value", offset, "m", "at most 1.4: the line must be in reach");
  }
  for (const char* key : {"lines", "pieces"})
    if (settings.integer(key) < 1)
      fail_input(fmt::format("setting '{}'", key), "value", static_cast<double>(settings.integer(key)), "",
                 "at least 1");
  for (const std::string& arm : settings.texts("line_arms")) (void)make_arm(arm);
}

void note_passages(Context& context) {
  const Table& table = context.table;
  for (const std::string& scene : {kTwo, kWrist, kThree})
    for (const Method& m : kMethods) {
      double speed = 0.0, error = 0.0, nearest = std::numeric_limits<double>::infinity();
      for (const std::size_t row : rows_of(table, "passage", scene, m.name)) {
        if (table.at(row, "status").text() != "ok") continue;
        nearest = std::min(nearest, table.at(row, "offset").number());
        speed = std::max(speed, table.at(row, "speed").number());
        error = std::max(error, table.at(row, "error").number());
      }
      if (speed > 0.0)
        context.note(
            fmt::format("{}, {}: down to {:.1e} from singular at most {:.3g} rad/s and {:.1e} m off.", scene,
                        m.name, nearest, speed, error));
    }
}

void body(Context& context) {
  check(context.settings);
  const auto offsets = static_cast<long>(context.settings.numbers("offsets").size());
  const std::vector<std::string> arms = context.settings.texts("line_arms");
  context.progress.start(3 * offsets + static_cast<long>(arms.size()) * context.settings.integer("lines"));
  study_passages(context, past_the_base);
  study_passages(context, past_the_wrist);
  study_passages(context, with_a_third_link);
  const double shown = context.settings.number("shown_offset");
  Chart along{
      .name = "robot",
      .title = fmt::format("Past a singular place, {:g} m or rad away", shown),
      .caption =
          "J^+ keeps to the path, to its tolerance of 1e-10 m, and its joints race; damped they keep their "
          "speed and leave the path for a while (a radian off counts as a metre); with a third link the "
          "joints "
          "need not race. Errors below 1e-12 m are drawn there."};
  add_along(context, past_the_base(shown), along);
  add_along(context, past_the_wrist(shown), along);
  add_along(context, with_a_third_link(shown), along);
  context.add_chart(std::move(along));
  context.add_chart(offsets_chart(context.table));
  note_passages(context);
  for (const std::string& arm : arms) study_lines(context, make_arm(arm));
  context.add_chart(lines_chart(context));
}

}  // namespace
}  // namespace feder::experiments

int main(int argc, char** argv) {
  return feder::experiments::run_experiment(feder::experiments::kInfo, argc, argv, feder::experiments::body);
}
