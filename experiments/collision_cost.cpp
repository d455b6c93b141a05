// What does a collision query cost, by mesh size and bounding volume, and what does the smallest ball? A
// bumpy sphere and a bumpy torus of T triangles each: a hierarchy is built and refitted, then asked for the
// first hit, for all pairs (a curve: about sqrt T of them) and for the distance (notes A18). Welzl's
// algorithm needs inside tests; the expected number per point of n points in R^d stays below (notes A17)
//   (d + 1)! sum_{j = 1 .. d + 1} 1/j! = 3, 10, 41 for d = 1, 2, 3.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

#include "engine/check.h"
#include "engine/geometry/bvh_queries.h"
#include "engine/geometry/bvh_traversal.h"
#include "engine/geometry/mesh_generators.h"
#include "engine/geometry/welzl_ball.h"
#include "engine/status.h"
#include "experiments/support/experiment.h"
#include "experiments/support/measure.h"
#include "experiments/support/timing.h"

namespace feder::experiments {
namespace {

constexpr const char* kMeshes = "bumpy sphere and torus";
constexpr const char* kPoints = "points in a cube";

// In [-1, 1), the same with every standard library.
double uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-52 - 1.0;
}

// ---- Time of one call

struct Timing {
  double best = 0.0, median = 0.0;
};

struct Limits {
  std::int64_t repeats;
  double max_seconds;
};

// measure() returns the seconds of one call.
template <class Measure>
Timing repeat(const Limits& limits, Measure&& measure) {
  const Stopwatch all;
  std::vector<double> seconds;
  do seconds.push_back(measure());
  while (static_cast<std::int64_t>(seconds.size()) < limits.repeats && all.seconds() < limits.max_seconds);
  return {*std::min_element(seconds.begin(), seconds.end()), median(seconds)};
}

// Short calls are timed many at once, for a millisecond at least; the first warms up.
template <class Call>
Timing repeat_short(const Limits& limits, Call&& call) {
  constexpr double kLeast = 1e-3;
  const Stopwatch watch;
  call();
  const double count = std::clamp(std::ceil(kLeast / (watch.seconds() + 1e-9)), 1.0, 1e6);
  return repeat(limits, [&] {
    const Stopwatch batch;
    for (double i = 0.0; i < count; ++i) call();
    return batch.seconds() / count;
  });
}

// ---- Two meshes near each other

// Where sphere and torus meet, and where they do not.
struct Placement {
  Pose torus, meeting, apart;
};
struct Scene {
  TriangleMesh sphere, torus;  // as many triangles each
  std::vector<Placement> placements;
};

// 1 within a tenth, waves along every axis.
double bump(const Vector3d& p) {
  return 1.0 + 0.1 * std::sin(6.0 * p[0] + 1.0) * std::sin(7.0 * p[1] + 2.0) * std::sin(5.0 * p[2] + 3.0);
}

TriangleMesh bumpy_sphere(int n) {
  TriangleMesh mesh = sphere_mesh("bumpy sphere", 1.0, n);
  for (Vector3d& p : mesh.vertices) p *= bump(p);
  return mesh;
}

TriangleMesh bumpy_torus(int n) {
  TriangleMesh mesh = torus_mesh("bumpy torus", 1.0, 0.3, 4 * n, n);
  for (Vector3d& p : mesh.vertices) {
    const Vector3d circle = Vector3d(p[0], p[1], 0.0).normalized();
    p = circle + bump(p) * (p - circle);
  }
  return mesh;
}

Matrix3d any_rotation(std::mt19937_64& random) {
  Eigen::Vector4d q;
  for (double& x : q) x = uniform(random);
  return Eigen::Quaterniond(q.normalized()).toRotationMatrix();
}

// The sphere comes along x; no step is longer than the distance, so that it stops where they first touch.
Scene make_scene(int n, const Settings& settings, std::uint64_t seed) {
  Scene scene{bumpy_sphere(n), bumpy_torus(n), {}};
  const Bvh<Obb> sphere(scene.sphere), torus(scene.torus);
  std::mt19937_64 random(seed);
  for (std::int64_t i = 0; i < settings.integer("placements"); ++i) {
    Placement place;
    place.torus.rotation = any_rotation(random);
    place.meeting = place.apart = {any_rotation(random), 4.0 * Vector3d::UnitX()};
    double& x = place.meeting.position[0];
    for (double distance = 1.0; distance > 1e-6; x -= distance)
      distance = closest_points(sphere, place.meeting, torus, place.torus)->distance;
    place.apart.position[0] = x + settings.number("gap");
    x -= settings.number("depth");
    scene.placements.push_back(place);
  }
  return scene;
}

// ---- What a hierarchy costs and answers

struct Answers {
  std::vector<std::vector<TrianglePair>> pairs;  // of each placement
  std::vector<double> distances;                 // [m]
  double volume_tests = 0.0, leaf_pairs = 0.0;   // for all pairs, sum over the placements

  double mean_pairs() const {
    double sum = 0.0;
    for (const auto& found : pairs) sum += static_cast<double>(found.size());
    return sum / static_cast<double>(pairs.size());
  }
};

// The walk of all_overlaps, counted.
template <class Volume>
void count_tests(const Bvh<Volume>& a, const Pose& pose_a, const Bvh<Volume>& b, const Pose& pose_b,
                 Answers& out) {
  const Relative frame =
      relative(pose_a, pose_b, reach_of(a.nodes()[0].volume) + reach_of(b.nodes()[0].volume));
  visit_leaf_pairs(
      a.nodes(), 0, b.nodes(), 0,
      [&](const Volume& x, const Volume& y) {
        out.volume_tests += 1.0;
        return apart(x, y, frame);
      },
      [&](const BvhNode<Volume>&, const BvhNode<Volume>&) {
        out.leaf_pairs += 1.0;
        return false;
      });
}

template <class Volume>
Status find_answers(const Scene& scene, const Bvh<Volume>& sphere, const Bvh<Volume>& torus, Answers& out) {
  Status status;
  for (const Placement& place : scene.placements) {
    out.pairs.push_back(all_overlaps(sphere, place.meeting, torus, place.torus));
    out.distances.push_back(closest_points(sphere, place.apart, torus, place.torus)->distance);
    count_tests(sphere, place.meeting, torus, place.torus, out);
    const bool hit = any_overlap(sphere, place.meeting, torus, place.torus).has_value();
    if (hit == out.pairs.back().empty())
      status = Status::failure(StatusCode::kInconsistent, "first hit and all pairs contradict each other");
  }
  return status;
}

// Every volume has to find the same.
Status compare(const Answers& first, const Answers& other) {
  for (std::size_t i = 0; i < first.pairs.size(); ++i) {
    if (first.pairs[i] != other.pairs[i])
      return Status::failure(StatusCode::kInconsistent,
                             fmt::format("placement {}: {} pairs, another volume found {}", i,
                                         other.pairs[i].size(), first.pairs[i].size()));
    if (!(std::abs(first.distances[i] - other.distances[i]) <= 1e-12))
      return Status::failure(StatusCode::kInconsistent,
                             fmt::format("placement {}: distance {} m, another volume found {} m", i,
                                         other.distances[i], first.distances[i]));
  }
  return {};
}

template <class Volume>
void measure_hierarchy(Context& context, const std::string& name, const Scene& scene,
                       std::optional<Answers>& agreed) {
  const Limits limits{context.settings.integer("repeats"), context.settings.number("max_seconds")};
  const double triangles = static_cast<double>(scene.sphere.triangles.size()),
               placements = static_cast<double>(scene.placements.size());
  const Bvh<Volume> sphere(scene.sphere), torus(scene.torus);
  Answers answers;
  Status status = find_answers(scene, sphere, torus, answers);
  if (!agreed) agreed = answers;
  if (status.ok()) status = compare(*agreed, answers);

  const auto add = [&](const char* quantity, const Timing& time, Table::Row more) {
    more.insert(more.end(), {{"scene", kMeshes},
                             {"volume", name},
                             {"triangles", scene.sphere.triangles.size()},
                             {"quantity", quantity},
                             {"status", to_string(status.code)},
                             {"reason", status.reason},
                             {"seconds", time.best},
                             {"seconds_median", time.median}});
    context.table.add(more);
    context.progress.advance(fmt::format("{} {} {}", quantity, name, triangles));
  };
  const auto ask = [&](auto&& query) {
    Timing time = repeat_short(limits, [&] {
      for (const Placement& place : scene.placements) query(place);
    });
    time.best /= placements, time.median /= placements;
    return time;
  };

  // build and refit, the sphere alone
  Bvh<Volume> tree;
  const Timing build = repeat(limits, [&] {
    const Stopwatch watch;
    Bvh<Volume> built(scene.sphere);
    const double seconds = watch.seconds();
    tree = std::move(built);
    return seconds;
  });
  add("build", build, {{"seconds_per_triangle", build.best / triangles}});
  std::vector<Vector3d> moved = scene.sphere.vertices;
  for (Vector3d& p : moved) p[0] += 0.1 * p[1];
  const Timing refit = repeat_short(limits, [&] { tree.refit(moved); });
  add("refit", refit, {{"seconds_per_triangle", refit.best / triangles}});

  // queries, mean of the placements
  add("first_hit", ask([&](const Placement& at) { return any_overlap(sphere, at.meeting, torus, at.torus); }),
      {});
  add("all_pairs",
      ask([&](const Placement& at) { return all_overlaps(sphere, at.meeting, torus, at.torus); }),
      {{"pairs", answers.mean_pairs()},
       {"volume_tests", answers.volume_tests / placements},
       {"leaf_pairs", answers.leaf_pairs / placements}});
  add("distance", ask([&](const Placement& at) { return closest_points(sphere, at.apart, torus, at.torus); }),
      {});
}

void measure_meshes(Context& context) {
  const std::vector<std::string> volumes = context.settings.texts("volumes");
  for (const double triangles : context.settings.numbers("triangles")) {
    const int n = std::max(3, static_cast<int>(std::lround(std::sqrt(triangles / 8.0))));
    const Scene scene = make_scene(n, context.settings, context.seed);
    std::optional<Answers> agreed;
    for (const std::string& volume : volumes) {
      if (context.interrupted()) return;
      if (volume == "sphere") measure_hierarchy<Sphere>(context, volume, scene, agreed);
      if (volume == "aabb") measure_hierarchy<Aabb>(context, volume, scene, agreed);
      if (volume == "obb") measure_hierarchy<Obb>(context, volume, scene, agreed);
    }
  }
}

// ---- The smallest ball

double bound_of_tests(int d) {
  double bound = 0.0, term = 1.0;
  for (int j = d + 1; j >= 1; --j) bound += term, term *= j;
  return bound;
}

// Of one dimension and number of points, over the seeds.
struct Balls {
  std::vector<double> tests, welzl_seconds, seconds;  // tests per point; seconds of a call
  double mean = 0.0, deviation = 0.0;                 // of the tests per point
  Status status;
};

// Fresh points and a fresh order for every seed.
Balls find_balls(const Context& context, int d, Eigen::Index n) {
  const std::int64_t seeds = context.settings.integer("seeds");
  Balls out;
  for (std::int64_t seed = 0; seed < seeds; ++seed) {
    std::mt19937_64 random(context.seed + static_cast<std::uint64_t>(seed));
    Eigen::MatrixXd points(d, n);
    for (double& x : points.reshaped()) x = uniform(random);
    const std::uint64_t order = random();
    const Stopwatch watch;
    const Ball smallest = smallest_ball(points);
    out.seconds.push_back(watch.seconds());
    const Stopwatch welzl_watch;
    const WelzlBall welzl = welzl_ball(points, order);
    out.welzl_seconds.push_back(welzl_watch.seconds());
    out.tests.push_back(static_cast<double>(welzl.inside_tests) / static_cast<double>(n));
    const double difference = std::abs(welzl.ball.radius - smallest.radius);
    if (!(difference <= 1e-12))
      out.status = Status::failure(StatusCode::kInconsistent,
                                   fmt::format("radii of the two algorithms differ by {} m", difference));
  }
  for (const double x : out.tests) out.mean += x / static_cast<double>(seeds);
  for (const double x : out.tests)
    out.deviation += std::pow(x - out.mean, 2) / static_cast<double>(seeds - 1);
  out.deviation = std::sqrt(out.deviation);
  return out;
}

void add_balls(Context& context, int d, Eigen::Index n, const Balls& balls) {
  const auto add = [&](const char* quantity, const std::vector<double>& seconds, Table::Row more) {
    more.insert(more.end(), {{"scene", kPoints},
                             {"quantity", quantity},
                             {"dimension", d},
                             {"points", n},
                             {"status", to_string(balls.status.code)},
                             {"reason", balls.status.reason},
                             {"seconds", *std::min_element(seconds.begin(), seconds.end())},
                             {"seconds_median", median(seconds)},
                             {"seconds_per_point", median(seconds) / static_cast<double>(n)}});
    context.table.add(more);
    context.progress.advance(fmt::format("{} {}", quantity, n));
  };
  add("welzl_ball", balls.welzl_seconds,
      {{"tests_per_point", balls.mean},
       {"tests_deviation", balls.deviation},
       {"tests_bound", bound_of_tests(d)}});
  add("smallest_ball", balls.seconds, {});
}

void measure_balls(Context& context) {
  const std::vector<double> sizes = context.settings.numbers("points");
  const double root = std::sqrt(context.settings.integer("seeds"));
  std::string tests, times;
  for (const int d : {1, 2, 3}) {
    Balls balls;
    for (const double size : sizes) {
      if (context.interrupted()) return;
      balls = find_balls(context, d, std::llround(size));
      add_balls(context, d, std::llround(size), balls);
    }
    const double seconds = median(balls.seconds), welzl = median(balls.welzl_seconds);
    tests += fmt::format("{}d = {}: {:.2f} +- {:.2f} (bound {})", d == 1 ? "" : ", ", d, balls.mean,
                         balls.deviation / root, bound_of_tests(d));
    times += fmt::format("{}d = {}: {:.2g} ns, Welzl {:.1f} times as long", d == 1 ? "" : ", ", d,
                         1e9 * seconds / sizes.back(), welzl / seconds);
  }
  context.note(fmt::format("Welzl's inside tests per point at n = {:g}, mean and its standard error: {}.",
                           sizes.back(), tests));
  context.note(fmt::format("smallest_ball takes per point at n = {:g}: {}.", sizes.back(), times));
}

// ---- Charts

bool is(const Table& table, std::size_t row, const char* column, const std::string& text) {
  return table.at(row, column).text() == text;
}

std::vector<Series> by_volume(const Table& table, const char* quantity, const char* y) {
  return series_by(table, "volume", "triangles", y,
                   [&](std::size_t row) { return is(table, row, "quantity", quantity); });
}

std::vector<Series> by_dimension(const Table& table, const char* quantity, const char* y) {
  std::vector<Series> all = series_by(table, "dimension", "points", y,
                                      [&](std::size_t row) { return is(table, row, "quantity", quantity); });
  for (Series& series : all) series.label = "d = " + series.label;
  return all;
}

Chart mesh_chart(const Table& table) {
  struct Part {
    const char *title, *unit, *quantity, *column;
    std::vector<Slope> slopes;
  };
  const Part parts[] = {
      {"Build", "per triangle [s]", "build", "seconds_per_triangle", {}},
      {"Refit", "per triangle [s]", "refit", "seconds_per_triangle", {}},
      {"First hit", "per query [s]", "first_hit", "seconds", {}},
      {"All pairs", "per query [s]", "all_pairs", "seconds", {{.order = 0.5, .label = "slope 1/2"}}},
      {"Volume tests for all pairs",
       "tests per query",
       "all_pairs",
       "volume_tests",
       {{.order = 0.5, .label = "slope 1/2"}}},
      {"Distance", "per query [s]", "distance", "seconds", {}}};
  Chart chart{.name = "collision_cost",
              .title = "A bumpy sphere and a bumpy torus: what their hierarchies cost",
              .caption = "Best time of one thread, by bounding volume; T triangles in each mesh.",
              .grid_columns = 3};
  for (const Part& part : parts)
    chart.panels.push_back({.title = part.title,
                            .x = {.label = "triangles T", .log = true},
                            .y = {.label = part.unit, .log = true},
                            .series = by_volume(table, part.quantity, part.column),
                            .slopes = part.slopes});
  return chart;
}

Chart ball_chart(const Table& table) {
  Panel tests{.title = "Welzl: inside tests per point, mean of the seeds",
              .x = {.label = "points n", .log = true},
              .y = {.label = "tests / n", .min = 0.0, .max = 45.0},
              .series = by_dimension(table, "welzl_ball", "tests_per_point")};
  for (const int d : {1, 2, 3})
    tests.marks.push_back({.at = bound_of_tests(d),
                           .label = fmt::format("bound d = {}: {}", d, bound_of_tests(d)),
                           .vertical = false});
  Chart chart{.name = "smallest_ball",
              .title = "The smallest ball around points in a cube",
              .caption = "The expected number of tests stays below the bound of each dimension.",
              .panels = {std::move(tests)}};
  chart.panels.push_back({.title = "Welzl: spread of the tests over the seeds",
                          .x = {.label = "points n", .log = true},
                          .y = {.label = "standard deviation of tests / n", .log = true},
                          .series = by_dimension(table, "welzl_ball", "tests_deviation")});
  constexpr std::pair<const char*, const char*> kTimes[] = {{"Welzl: time", "welzl_ball"},
                                                            {"smallest_ball: time", "smallest_ball"}};
  for (const auto& [title, quantity] : kTimes)
    chart.panels.push_back({.title = title,
                            .x = {.label = "points n", .log = true},
                            .y = {.label = "per point [s]", .log = true, .min = 1e-9, .max = 1e-6},
                            .series = by_dimension(table, quantity, "seconds_per_point")});
  return chart;
}

// ---- Conclusions

// Values of `column` at the largest size by group, and how fast the column grows.
std::string last_values(const std::vector<Series>& all, double scale, bool growth) {
  std::string text;
  for (const Series& series : all) {
    if (series.x.empty()) continue;
    text += fmt::format("{}{} {:.3g}", text.empty() ? "" : ", ", series.label, scale * series.y.back());
    if (growth && series.x.size() > 1)
      text += fmt::format(" (~ T^{:.2f})", fit_power(series.x, series.y).slope);
  }
  return text;
}

void conclude_meshes(Context& context) {
  const Table& table = context.table;
  double triangles = 0.0, pairs = 0.0;
  for (std::size_t row = 0; row < table.rows(); ++row)
    if (is(table, row, "quantity", "all_pairs") && table.at(row, "triangles").number() >= triangles)
      triangles = table.at(row, "triangles").number(), pairs = table.at(row, "pairs").number();
  const auto values = [&](const char* quantity, const char* column, double scale, bool growth) {
    return last_values(by_volume(table, quantity, column), scale, growth);
  };
  context.note(fmt::format("At {:.0f} triangles a build takes, in ns per triangle: {}; a refit: {}.",
                           triangles, values("build", "seconds_per_triangle", 1e9, false),
                           values("refit", "seconds_per_triangle", 1e9, false)));
  constexpr std::pair<const char*, const char*> kQueries[] = {
      {"first_hit", "The first hit"}, {"all_pairs", "All pairs"}, {"distance", "The distance"}};
  for (const auto& [quantity, subject] : kQueries)
    context.note(fmt::format("{} of two meshes of {:.0f} triangles, in microseconds: {}.", subject, triangles,
                             values(quantity, "seconds", 1e6, true)));
  context.note(fmt::format("Volume tests for those {:.0f} pairs: {}; pairs of leaves that remain: {}.", pairs,
                           values("all_pairs", "volume_tests", 1.0, false),
                           values("all_pairs", "leaf_pairs", 1.0, false)));
}

void check(const Context& context) {
  const auto require = [](const char* key, double value, double low, double high) {
    if (!(value >= low && value <= high))
      fail_input(fmt::format("setting '{}'", key), "value", value, "",
                 fmt::format("{:g} to {:g}", low, high));
  };
  for (const double x : context.settings.numbers("triangles")) require("triangles", x, 8.0, 1e8);
  for (const double x : context.settings.numbers("points")) require("points", x, 2.0, 1e8);
  require("placements", static_cast<double>(context.settings.integer("placements")), 1.0, 1e4);
  require("seeds", static_cast<double>(context.settings.integer("seeds")), 2.0, 1e6);
  require("depth", context.settings.number("depth"), 0.0, 0.5);
  require("gap", context.settings.number("gap"), 0.0, 10.0);
}

void body(Context& context) {
  check(context);
  context.progress.start(static_cast<long>(5 * context.settings.numbers("triangles").size() *
                                               context.settings.texts("volumes").size() +
                                           6 * context.settings.numbers("points").size()));
  measure_meshes(context);
  measure_balls(context);
  if (context.interrupted()) return;
  context.add_chart(mesh_chart(context.table));
  context.add_chart(ball_chart(context.table));
  conclude_meshes(context);
}

ExperimentInfo about() {
  return {
      .name = "collision_cost",
      .question =
          "What does a collision query cost, by mesh size and bounding volume, and what does the smallest "
          "ball?",
      .not_modelled =
          "One pair of smooth closed surfaces and one thread: no triangle soups, no self "
          "contact, no reuse of the last step's answer.",
      .settings = {{"triangles", Kind::kNumbers, "1e3:1e5:5", "1e3:1e6:10", "of each mesh, about"},
                   {"volumes",
                    Kind::kTexts,
                    "sphere,aabb,obb",
                    "sphere,aabb,obb",
                    "bounding volumes of the hierarchy",
                    {"sphere", "aabb", "obb"}},
                   {"placements", Kind::kInteger, "8", "16", "generic poses, the queries' mean is taken"},
                   {"depth", Kind::kNumber, "0.02", "0.02", "how far the sphere is pushed in, m"},
                   {"gap", Kind::kNumber, "0.02", "0.02", "how far it is drawn back, m"},
                   {"points", Kind::kNumbers, "1e2:1e5:4", "1e2:1e6:9", "in the smallest ball"},
                   {"seeds", Kind::kInteger, "100", "400", "point sets and orders of each size"},
                   {"repeats", Kind::kInteger, "7", "25", "of each timing, at most"},
                   {"max_seconds", Kind::kNumber, "0.1", "5", "budget of the repeats of a timing, s"}},
      .columns = {"scene", "volume", "triangles", "quantity", "dimension", "points", "status", "reason",
                  "pairs", "volume_tests", "leaf_pairs", "tests_per_point", "tests_deviation", "tests_bound",
                  "seconds", "seconds_median", "seconds_per_triangle", "seconds_per_point"},
      .cases = {"bumpy sphere and torus: build, refit, first_hit, all_pairs, distance",
                "points in a cube: welzl_ball, smallest_ball"}};
}

}  // namespace
}  // namespace feder::experiments

int main(int argc, char** argv) {
  return feder::experiments::run_experiment(feder::experiments::about(), argc, argv,
                                            feder::experiments::body);
}
